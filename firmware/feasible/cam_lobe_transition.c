// SPDX-License-Identifier: Apache-2.0
#include "cam_lobe_transition.h"

/// Places of the smooth step.
enum { n_places = 20 };

/// [1e-6] what lies between the places.
enum { between_ppm = 1010000 };

/// The smooth step and the magnitudes of its derivatives at a place, in 1e-6.
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

static uint64_t larger(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

/// @return whether the lift changes at all: more than one lobe
static bool has_change(const cam_table_t *t)
{
    return t->least_change_nm > 0u;
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

uint64_t cam_lobe_transition_first(const cam_table_t *t, uint64_t feed_nm,
                                   const cam_lobe_transition_peaks_t *peaks)
{
    uint64_t most = peaks->f1;
    if (!has_change(t)) {
        return most;
    }
    const uint64_t f_x = part(peaks->f, x_ppm(t, feed_nm));
    uint64_t before = 0;
    for (uint64_t i = 1; i <= (uint64_t)n_places; i++) {
        const step_t at = step_at(i);
        const uint64_t more = part(f_x, at.e1);
        most = larger(most, part(peaks->f1, at.e) + part(larger(before, more), between_ppm));
        before = more;
    }
    return most;
}

uint64_t cam_lobe_transition_second(const cam_table_t *t, uint64_t feed_nm,
                                    const cam_lobe_transition_peaks_t *peaks, uint32_t n_set_points)
{
    uint64_t most = peaks->f2;
    if (!has_change(t)) {
        return most;
    }
    const uint64_t x = x_ppm(t, feed_nm);
    const uint64_t f_x = part(peaks->f, x);
    const uint64_t f_xx = part(f_x, x) * n_set_points;
    const uint64_t f1_x = part(peaks->f1, x);
    const uint64_t f_xs = part(f_x, t->spindle_peak_ppm_per_rad) * n_set_points;
    uint64_t before = 0;
    for (uint64_t i = 1; i <= (uint64_t)n_places; i++) {
        const step_t at = step_at(i);
        const uint64_t more = part(2u * f1_x + f_xs, at.e1) + part(f_xx, at.e2);
        most = larger(most, part(peaks->f2, at.e) + part(larger(before, more), between_ppm));
        before = more;
    }
    return most;
}
