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
