// SPDX-License-Identifier: Apache-2.0
#include "cam_z_coupling.h"
#include "cam_feed.h" // cam_feed_ramp_q32
#include <stdbool.h>  // bool
#include <stddef.h>   // NULL

/// @return whether Z is geared along a ring-helix
static bool has_rings(const cam_cut_t *c)
{
    return c->t->is_ring_helix && c->p->z_is_measured == 0;
}

/// @return [um/s] speed of Z along a helix with the mean feed, below 2^44
static uint64_t plain_um_per_s(const cam_cut_t *c)
{
    return cam_cut_divided_up(c->feed_nm * c->peak_mrpm, 60000000);
}

/// @return [1e-6] largest feed over its mean
static uint64_t way_slope_ppm(const cam_cut_t *c)
{
    return c->p->z_is_measured == 0 && c->t->way.knots != NULL ? c->t->way_slope_ppm : 1000000u;
}

/// Where the feed changes with the height, Z accelerates by that change times the square of its
/// mean speed. @return [mm/s2]
static uint64_t way_mm_per_s2(const cam_cut_t *c)
{
    if (c->t->way.knots == NULL) {
        return 0;
    }
    const int64_t v_um_per_s =
        cam_cut_smaller((int64_t)plain_um_per_s(c), cam_z_coupling_max_z_um_per_s);
    const uint64_t v_tenth_mm_per_s = (uint64_t)v_um_per_s / 100u + 1u;
    return v_tenth_mm_per_s * v_tenth_mm_per_s * c->t->way_bend_ppm_per_m / 100000000000u + 1u;
}

uint64_t cam_z_coupling_z_um_per_s(const cam_cut_t *c)
{
    if (!has_rings(c)) {
        return cam_cut_divided_up(plain_um_per_s(c) * way_slope_ppm(c), 1000000);
    }
    const uint32_t feed_nm = (uint32_t)c->feed_nm;
    const uint32_t ramp_q32 =
        cam_feed_ramp_q32(feed_nm, c->peak_mrpm, (uint32_t)c->p->z_acceleration_mm_per_s2);
    return cam_feed_speed_um_per_s(feed_nm, c->peak_mrpm, ramp_q32);
}

/// @return [mm/s2] acceleration along a plain helix
static uint64_t ramp_mm_per_s2(const cam_cut_t *c)
{
    const uint64_t turns = (uint64_t)c->p->feed_ramp_turns;
    const uint64_t rpm = cam_cut_divided_up(c->peak_mrpm, 1000);
    const uint64_t feed_nm = c->programmed_nm;
    const uint64_t per = turns * feed_nm <= cam_cut_span_nm(c)
                             ? UINT64_C(3600000000) * turns
                             : UINT64_C(3600000000) * cam_cut_span_nm(c) / feed_nm;
    return cam_cut_divided_up(feed_nm * rpm * rpm, per);
}

uint64_t cam_z_coupling_z_mm_per_s2(const cam_cut_t *c)
{
    return has_rings(c) ? cam_feed_least_acceleration((uint32_t)c->feed_nm, c->peak_mrpm)
                        : cam_cut_divided_up(ramp_mm_per_s2(c) * way_slope_ppm(c), 1000000) +
                              way_mm_per_s2(c);
}

uint64_t cam_z_coupling_z_feeding_mm_per_s2(const cam_cut_t *c)
{
    return has_rings(c)               ? (uint64_t)c->p->z_acceleration_mm_per_s2
           : c->p->z_is_measured != 0 ? 0u
                                      : cam_z_coupling_z_mm_per_s2(c);
}

uint64_t cam_z_coupling_x_um_per_s(const cam_cut_t *c)
{
    return c->t->has_stations ? plain_um_per_s(c) : cam_z_coupling_z_um_per_s(c);
}

uint64_t cam_z_coupling_x_mm_per_s2(const cam_cut_t *c)
{
    return c->t->has_stations ? ramp_mm_per_s2(c) : cam_z_coupling_z_feeding_mm_per_s2(c);
}

cam_z_coupling_t cam_z_coupling_of(const cam_cut_t *c, const cam_channel_t *ch,
                                   const cam_change_t *change, uint32_t set_point_hz)
{
    if (c->t->n_lobes > 0u) {
        return (cam_z_coupling_t){0};
    }
    const uint64_t spacing_nm = ch->span_nm / (ch->n_slices - 1u);
    const uint64_t v_um_per_s = (uint64_t)cam_cut_smaller((int64_t)cam_z_coupling_z_um_per_s(c),
                                                          cam_z_coupling_max_z_um_per_s);
    const uint64_t a_mm_per_s2 =
        (uint64_t)cam_cut_smaller((int64_t)cam_z_coupling_z_feeding_mm_per_s2(c), 1000000);
    const uint64_t rate_uHz = cam_cut_divided_up(v_um_per_s * 1000000000u, spacing_nm);
    const uint64_t rise_mHz_per_s = cam_cut_divided_up(a_mm_per_s2 * 1000000000u, spacing_nm);
    const uint64_t jump = cam_cut_divided_up(change->kink * rate_uHz, 1000000) * set_point_hz;
    return (cam_z_coupling_t){
        .speed = cam_cut_divided_up(change->most * rate_uHz, 1000000000),
        .speed_per_rad =
            cam_cut_divided_up(change->per_rad * cam_cut_divided_up(rate_uHz, 1000), 1000000),
        .acceleration = cam_cut_divided_up(
            jump + cam_cut_divided_up(change->most * rise_mHz_per_s, 1000), 1000),
    };
}

uint64_t cam_z_coupling_acceleration(const cam_cut_t *c, const cam_z_coupling_t *d)
{
    const uint64_t omega_crad_per_s =
        cam_cut_divided_up(cam_cut_omega_mrad_per_s(c->peak_mrpm), 10);
    return cam_cut_divided_up(2u * d->speed_per_rad * omega_crad_per_s, 100) + d->acceleration;
}

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

/// @return a * ppm / 10^6, rounded up, saturated
static uint64_t part(uint64_t a, uint64_t ppm)
{
    return cam_cut_scaled_up(a, ppm, 1000000);
}

/// @return [1e-6] x = R / (2 pi N), at most 2^25; with a speed channel the lift has half the height
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

uint64_t cam_z_coupling_lobes_first(const cam_table_t *t, uint64_t feed_nm,
                                    const cam_z_coupling_peaks_t *peaks)
{
    if (t->least_change_nm == 0u) { // a single lobe, or none
        return peaks->f1;
    }
    return bound(peaks->f1, (const uint64_t[]){part(peaks->f, x_ppm(t, feed_nm)), 0});
}

uint64_t cam_z_coupling_lobes_second(const cam_table_t *t, uint64_t feed_nm,
                                     const cam_z_coupling_peaks_t *peaks, uint32_t n_set_points)
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
