// SPDX-License-Identifier: Apache-2.0
#include "cam_spindle_demand.h"
#include "cam_fix.h"   // cam_per_rad
#include "cam_lobes.h" // cam_lobes_slice
#include "cam_speed.h" // cam_speed_scaled, cam_speed_ratio_at
#include <stdbool.h>   // bool

/// @return [2^-20] a derivative per turn as one per rad, rounded away from 0
static int64_t per_rad_q20(int64_t per_turn_q20)
{
    const int64_t magnitude = cam_per_rad(cam_abs_i64(per_turn_q20)) + 1;
    return per_turn_q20 < 0 ? -magnitude : magnitude;
}

static uint32_t raised(uint32_t most, int64_t value)
{
    return value > (int64_t)most ? (uint32_t)value : most;
}

/// Raise the demand to that of one knot.
static void raise_demand(cam_spindle_demand_t *demand, cam_ratio_t at)
{
    const int64_t slope_q20 = per_rad_q20(at.slope_q20);
    const int64_t product_q20 = per_rad_q20(((int64_t)at.ratio_q28 * at.slope_q20) >> 28);
    const int64_t ratio_q20 = ((int64_t)at.ratio_q28 >> 8) + 1;
    demand->fall_ppm_per_rad = raised(demand->fall_ppm_per_rad, (-slope_q20 * 1000000) >> 20);
    demand->rise_q20 = raised(demand->rise_q20, product_q20);
    for (int k = 0; k < cam_spindle_demand_places; k++) {
        demand->set_q20[k] = raised(demand->set_q20[k],
                                    ratio_q20 + product_q20 * k * k / cam_spindle_demand_per_rad);
    }
}

cam_spindle_demand_t cam_spindle_demand_of(const cam_channel_t *ch)
{
    cam_spindle_demand_t demand = {0};
    for (int k = 0; k < cam_spindle_demand_places; k++) {
        demand.set_q20[k] = (uint32_t)CAM_TABLE_RATIO_ONE;
    }
    const uint32_t n = ch->knots != NULL ? ch->n_slices << ch->log2_knots : 0u;
    for (uint32_t i = 0; i < n; i++) {
        const cam_value_t at = {.y = ch->knots[i].p, .d1 = ch->knots[i].v};
        raise_demand(&demand, cam_speed_scaled(ch, at));
    }
    return demand;
}

uint64_t cam_spindle_demand_set_q20(const cam_spindle_demand_t *demand, uint64_t c_q16)
{
    const uint64_t one_q16 = 65536u / (uint64_t)cam_spindle_demand_per_rad; // c of the first step
    uint64_t k = 0;
    while (k + 1u < (uint64_t)cam_spindle_demand_places && (k + 1u) * (k + 1u) * one_q16 <= c_q16) {
        k++;
    }
    const uint64_t from = demand->set_q20[k];
    const uint64_t beyond_q16 = c_q16 - k * k * one_q16;
    if (k + 1u == (uint64_t)cam_spindle_demand_places) {
        return from + ((demand->rise_q20 * beyond_q16) >> 16) + 1u;
    }
    const uint64_t to = demand->set_q20[k + 1u];
    return from + (to > from ? (to - from) * beyond_q16 / ((2u * k + 1u) * one_q16) : 0u) + 1u;
}

/// [nm/turn2] larger curvatures are refused: no axis follows 28 m/rad2, and smaller ones keep the
/// products here within 64 bits.
#define MAX_CURVE (INT64_C(1) << 40)

/// @return the magnitude of a derivative per turn, as one per rad
static int64_t per_rad(int64_t x)
{
    return cam_per_rad(cam_abs_i64(x));
}

/// @return whether a value keeps its limit, with 1/4096 of it and 2 allowed for rounding here
static bool is_kept(int64_t found, uint32_t limit)
{
    return found - (found >> 12) - 2 <= (int64_t)limit;
}

/// @param k  index of a knot of channel ch, counted over all slices
/// @return   the speed ratio at the angle and the height of this knot
static cam_ratio_t ratio_at(const cam_table_t *t, const cam_channel_t *ch, uint32_t k)
{
    const uint32_t in_slice = k & ((1u << ch->log2_knots) - 1u);
    const uint32_t theta_q32 = in_slice << (32u - ch->log2_knots - ch->log2_repeat);
    const uint32_t slice = k >> ch->log2_knots;
    const uint64_t up_nm = (uint64_t)ch->span_nm * slice / (ch->n_slices - 1u);
    const cam_height_t z = t->lobes != NULL
                               ? cam_lobes_slice(t->speed.n_slices, slice)
                               : cam_eval_height(&t->speed, ch->z_first_nm + (int32_t)up_nm);
    return cam_speed_ratio_at(&t->speed, theta_q32, z);
}

/// Check speed and acceleration of U at knot k of u.
static bool is_motion_kept(const cam_table_t *t, uint32_t k)
{
    const cam_channel_t *u = &t->u;
    const uint32_t shift = u->log2_knots + u->log2_repeat;
    const cam_ratio_t ratio = ratio_at(t, u, k);
    const int64_t r_q14 = ratio.ratio_q28 >> 14;
    const int64_t slope = (int64_t)u->knots[k].v * (INT64_C(1) << shift) >> u->frac_bits;
    const int64_t twice_a = INT64_C(2) * u->knots[k].a;
    const int64_t curve_turn = twice_a * (INT64_C(1) << shift) >> u->frac_bits; // / turn / knot
    if (cam_abs_i64(curve_turn) > MAX_CURVE >> shift) {
        return false;
    }
    // u'' r^2 + u' r r', with r in q14 so that the products fit 64 bits.
    const int64_t bend = (curve_turn * (INT64_C(1) << shift) * ((r_q14 * r_q14) >> 14)) >> 14;
    const int64_t rr_q14 = (r_q14 * (ratio.slope_q20 >> 6)) >> 14;
    const int64_t acceleration = bend + ((slope * rr_q14) >> 14);
    return is_kept(per_rad((slope * r_q14) >> 14), t->u1_peak_nm_per_rad) &&
           is_kept(per_rad(per_rad(acceleration)), t->u2_peak_nm_per_rad2);
}

cam_err_t cam_header_limits_check(const cam_table_t *t)
{
    const uint32_t n_u = t->u.n_slices << t->u.log2_knots;
    const uint32_t n_speed = t->speed.n_slices << t->speed.log2_knots;
    for (uint32_t k = 0; k < n_u; k++) {
        if (!is_motion_kept(t, k)) {
            return cam_err_image_limits;
        }
    }
    for (uint32_t k = 0; k < n_speed; k++) {
        const cam_ratio_t ratio = ratio_at(t, &t->speed, k);
        const int64_t rr_q20 = ((int64_t)ratio.ratio_q28 * ratio.slope_q20) >> 28;
        if (!is_kept((per_rad(rr_q20) * 1000000) >> 20, t->spindle_peak_ppm_per_rad)) {
            return cam_err_image_limits;
        }
    }
    return cam_ok;
}
