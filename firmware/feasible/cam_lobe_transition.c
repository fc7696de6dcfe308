// SPDX-License-Identifier: Apache-2.0
#include "cam_lobe_transition.h"
#include "cam_cut.h" // cam_cut_greater

/// The smooth step is evaluated at this many points; between them it is at most 1 % larger.
enum { n_places = 20, between_ppm = 1010000 };

/// The smooth step and the magnitudes of its derivatives at a point, in 1e-6.
typedef struct {
    uint64_t e, e1, e2;
} step_t;

/// @param i  twentieths, 0 .. 20
static step_t step_at(uint64_t i)
{
    const uint64_t left = n_places - i;
    const uint64_t skew = left > i ? left - i : i - left;
    return (step_t){
        .e = i * i * i * (4000u - 300u * i + 6u * i * i) * 5u / 16u, // / 20^5 * 10^6
        .e1 = 30u * i * i * left * left * 25u / 4u,                  // / 20^4 * 10^6
        .e2 = 60u * i * left * skew * 125u,                          // / 20^3 * 10^6
    };
}

/// @return a * ppm / 10^6, rounded up, for a product below 2^64
static uint64_t part(uint64_t a, uint64_t ppm)
{
    return (a * ppm + 999999u) / 1000000u;
}

/// @return [1e-6] x = R / (2 pi N), at most 2^25; a table with a speed channel has half the height
///         for its lift
static uint64_t x_ppm(const cam_table_t *t, uint64_t feed_nm)
{
    const uint64_t change_nm =
        t->speed.knots != NULL ? t->least_change_nm / 2u : t->least_change_nm;
    const uint64_t per_turn_ppb = (feed_nm * 159154944u / change_nm + 1u); // 10^9 / (2 pi N)
    const uint64_t ppm = ((per_turn_ppb * t->ratio_max_q20) >> 20) / 1000u + 1u;
    return ppm < UINT64_C(1) << 25 ? ppm : UINT64_C(1) << 25;
}

/// @param f   [unit/rad^n] the magnitude that the smooth step scales
/// @param by  [unit/rad^n] the factors of the magnitudes of E' and E''
/// @return    bound of f E + by[0] E' + by[1] E'' over the step, at least f
static uint64_t bound(uint64_t f, const uint64_t by[2])
{
    uint64_t most = f;
    uint64_t before = 0;
    for (uint64_t i = 1; i <= (uint64_t)n_places; i++) {
        const step_t at = step_at(i);
        const uint64_t more = part(by[0], at.e1) + part(by[1], at.e2);
        const uint64_t between = part(cam_cut_greater(before, more), between_ppm);
        most = cam_cut_greater(most, part(f, at.e) + between);
        before = more;
    }
    return most;
}

uint64_t cam_lobe_transition_first(const cam_table_t *t, uint64_t feed_nm,
                                   const cam_lobe_transition_peaks_t *peaks)
{
    if (t->least_change_nm == 0u) { // a single lobe, or none
        return peaks->f1;
    }
    return bound(peaks->f1, (const uint64_t[]){part(peaks->f, x_ppm(t, feed_nm)), 0});
}

uint64_t cam_lobe_transition_second(const cam_table_t *t, uint64_t feed_nm,
                                    const cam_lobe_transition_peaks_t *peaks, uint32_t n_set_points)
{
    if (t->least_change_nm == 0u) {
        return peaks->f2;
    }
    const uint64_t x = x_ppm(t, feed_nm);
    const uint64_t f_x = part(peaks->f, x);
    const uint64_t f_xs = part(f_x, t->spindle_peak_ppm_per_rad) * n_set_points;
    return bound(peaks->f2,
                 (const uint64_t[]){2u * part(peaks->f1, x) + f_xs, part(f_x, x) * n_set_points});
}
