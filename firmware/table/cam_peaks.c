// SPDX-License-Identifier: Apache-2.0
#include "cam_table_inner.h"
#include "cam_fix.h"  // cam_abs_i64, cam_root_u64
#include "cam_eval.h" // cam_lobes_slice, cam_speed_scaled, cam_speed_ratio_at

enum {
    // [degrees / 1000] a turn, over 2 pi and over (2 pi)^2, rounded up: they convert an angle in
    // turns and its derivatives per turn to degrees and radians
    mdeg_per_turn = 360000,
    mdeg_per_turn_rad = 57296,
    mdeg_per_turn_rad2 = 9119,
    turn_per_rad_q20 = 166887, // [2^-20] 1 / 2 pi, rounded up
    samples_per_slice = 4,     // of a channel over height
    unit_bits = 26,            // fraction bits of the unit of an angle channel, 2^-26 turn
};

static uint32_t saturated(int64_t v)
{
    return v < (int64_t)UINT32_MAX ? (uint32_t)v : UINT32_MAX;
}

static void raise_to(uint32_t *most, int64_t value)
{
    *most = value > (int64_t)*most ? saturated(value) : *most;
}

static int64_t intervals_per_turn(const cam_channel_t *ch)
{
    return INT64_C(1) << (ch->log2_knots + ch->log2_repeat);
}

cam_swing_peaks_t cam_peaks_of_swing(const cam_channel_t *ch)
{
    const uint32_t n = ch->n_slices << ch->log2_knots;
    const int64_t offset = (int64_t)ch->value_offset * (INT64_C(1) << ch->frac_bits);
    cam_bounds_t b = {0};
    for (uint32_t i = 0; i < n; i++) {
        const cam_wide_knot_t k0 = cam_bounds_wide(&ch->knots[i], offset);
        const cam_wide_knot_t k1 = cam_bounds_wide(&ch->knots[cam_bounds_next(ch, i)], offset);
        cam_bounds_add(&b, &k0, &k1);
        cam_bounds_add_second(&b, &k0, &k1);
    }
    // A bound is a number of LSB of 2^-(26 + frac_bits) turn, taken tenfold, twofold or 8192-fold.
    // Adding 1 before and after each shift rounds it up.
    const uint32_t down = unit_bits + ch->frac_bits;
    const int64_t second =
        ((((b.second_8192 >> 13) + 1) * intervals_per_turn(ch) * mdeg_per_turn_rad2) >> 13) + 1;
    return (cam_swing_peaks_t){
        .most_mdeg = saturated(((b.tenfold / 10 + 1) * mdeg_per_turn >> down) + 1),
        .first_mdeg_per_rad =
            saturated((b.twice * intervals_per_turn(ch) * mdeg_per_turn_rad >> (down + 1u)) + 1),
        .second_mdeg_per_rad2 = saturated((second * intervals_per_turn(ch) >> (down - 13u)) + 1),
    };
}

/// @return difference between knot i and the knot above it in the next slice
static cam_wide_knot_t slice_step(const cam_channel_t *ch, uint32_t i)
{
    const cam_knot_t *from = &ch->knots[i];
    const cam_knot_t *to = &from[UINT32_C(1) << ch->log2_knots];
    return (cam_wide_knot_t){(int64_t)to->p - from->p, (int64_t)to->v - from->v,
                             (int64_t)to->a - from->a};
}

/// @return that difference less the one from the slice below to this slice
static cam_wide_knot_t slice_bend(const cam_channel_t *ch, uint32_t i)
{
    const cam_wide_knot_t above = slice_step(ch, i);
    const cam_wide_knot_t below = slice_step(ch, i - (UINT32_C(1) << ch->log2_knots));
    return (cam_wide_knot_t){above.p - below.p, above.v - below.v, above.a - below.a};
}

/// @return a number of LSB in the unit of the channel, rounded up, saturated
static uint32_t in_unit(const cam_channel_t *ch, int64_t lsb)
{
    return saturated((lsb + (INT64_C(1) << ch->frac_bits) - 1) >> ch->frac_bits);
}

/// @return a derivative per knot interval as per radian, rounded up, saturated
static int64_t derivative_per_rad(const cam_channel_t *ch, int64_t d)
{
    const int64_t rad_q20 = intervals_per_turn(ch) * turn_per_rad_q20;
    return d < INT64_MAX / rad_q20 ? (d * rad_q20 >> 20) + 1 : INT64_MAX / rad_q20;
}

uint32_t cam_peaks_third(const cam_channel_t *ch)
{
    cam_bounds_t b = {0};
    for (uint32_t i = 0; i < ch->n_slices << ch->log2_knots; i++) {
        const cam_wide_knot_t k0 = cam_bounds_wide(&ch->knots[i], 0);
        const cam_wide_knot_t k1 = cam_bounds_wide(&ch->knots[cam_bounds_next(ch, i)], 0);
        cam_bounds_add_third(&b, &k0, &k1);
    }
    return in_unit(ch,
                   derivative_per_rad(ch, derivative_per_rad(ch, derivative_per_rad(ch, b.third))));
}

uint32_t cam_peaks_rms_second(const cam_channel_t *ch)
{
    const uint32_t n_in_slice = UINT32_C(1) << ch->log2_knots;
    uint64_t most = 0;
    for (uint32_t slice = 0; slice < ch->n_slices; slice++) {
        const cam_knot_t *first = &ch->knots[slice << ch->log2_knots];
        uint64_t mean_square = 0;
        for (uint32_t i = 0; i < n_in_slice; i++) {
            const int64_t a = first[i].a;
            mean_square += ((uint64_t)(a * a) >> ch->log2_knots) + 1u;
        }
        most = mean_square > most ? mean_square : most;
    }
    const int64_t rms = 2 * (int64_t)cam_root_u64(most) + 2; // a knot has half the derivative
    return in_unit(ch, derivative_per_rad(ch, derivative_per_rad(ch, rms)));
}

cam_change_t cam_peaks_of_change(const cam_channel_t *ch)
{
    const uint32_t n_in_slice = UINT32_C(1) << ch->log2_knots;
    const uint32_t n = (ch->n_slices - 1u) << ch->log2_knots;
    cam_bounds_t steps = {0};
    cam_bounds_t bends = {0};
    for (uint32_t i = 0; i < n; i++) {
        const uint32_t next = cam_bounds_next(ch, i);
        const cam_wide_knot_t k0 = slice_step(ch, i);
        const cam_wide_knot_t k1 = slice_step(ch, next);
        cam_bounds_add(&steps, &k0, &k1);
        if (i >= n_in_slice) { // the first slice has none below it, so the rate cannot jump there
            const cam_wide_knot_t b0 = slice_bend(ch, i);
            const cam_wide_knot_t b1 = slice_bend(ch, next);
            cam_bounds_add(&bends, &b0, &b1);
        }
    }
    const int64_t slope_q20 = (steps.twice + 1) / 2 * intervals_per_turn(ch) * turn_per_rad_q20;
    return (cam_change_t){
        .most = in_unit(ch, (steps.tenfold + 9) / 10),
        .per_rad = in_unit(ch, (slope_q20 + (1 << 20) - 1) >> 20),
        .kink = in_unit(ch, (bends.tenfold + 9) / 10),
    };
}

/// @param per_slice_lsb  [LSB per slice]
/// @return               [1e-6] its magnitude as a slope, below 2^62
static int64_t slope_ppm(const cam_channel_t *x, int64_t per_slice_lsb)
{
    const int64_t rise = cam_abs_i64(per_slice_lsb) * 1000000 * (x->n_slices - 1u);
    return (rise >> x->frac_bits) / x->span_nm;
}

/// @param per_slice_ppm  [1e-6 per slice]
/// @return               [1e-6 / mm] rounded up
static int64_t bend_ppm_per_mm(const cam_channel_t *x, int64_t per_slice_ppm)
{
    const uint64_t per_mm = UINT64_C(1000000) * (x->n_slices - 1u);
    return (int64_t)cam_scaled_up_u64((uint64_t)per_slice_ppm, per_mm, x->span_nm);
}

cam_x_slope_t cam_x_slope_of(const cam_channel_t *x)
{
    const uint32_t n = (x->n_slices - 1u) * (uint32_t)samples_per_slice;
    cam_x_slope_t most = {0};
    for (uint32_t i = 0; i <= n; i++) {
        const int32_t up_nm = (int32_t)((uint64_t)x->span_nm * i / n);
        const cam_value_t at = cam_eval_profile(x, x->z_first_nm + up_nm);
        const int64_t slope = slope_ppm(x, at.d1);
        raise_to(&most.slope_ppm, slope);
        raise_to(&most.rise_ppm, at.d1 > 0 ? slope : 0);
        raise_to(&most.bend_ppm_per_mm, bend_ppm_per_mm(x, slope_ppm(x, at.d2)));
    }
    return most;
}

/// @return the magnitude of a derivative per turn, as one per rad
static int64_t per_rad(int64_t x)
{
    return cam_per_rad(cam_abs_i64(x));
}

/// @return [2^-20] a derivative per turn as one per rad, rounded away from 0
static int64_t per_rad_q20(int64_t per_turn_q20)
{
    const int64_t magnitude = per_rad(per_turn_q20) + 1;
    return per_turn_q20 < 0 ? -magnitude : magnitude;
}

static void raise_demand(cam_spindle_demand_t *demand, cam_ratio_t at)
{
    const int64_t slope_q20 = per_rad_q20(at.slope_q20);
    const int64_t product_q20 = per_rad_q20(((int64_t)at.ratio_q28 * at.slope_q20) >> 28);
    const int64_t ratio_q20 = ((int64_t)at.ratio_q28 >> 8) + 1;
    raise_to(&demand->fall_ppm_per_rad, (-slope_q20 * 1000000) >> 20);
    raise_to(&demand->rise_q20, product_q20);
    for (int k = 0; k < cam_spindle_demand_places; k++) {
        raise_to(&demand->set_q20[k], ratio_q20 + product_q20 * k * k / cam_spindle_demand_per_rad);
    }
}

cam_spindle_demand_t cam_peaks_of_speed(const cam_channel_t *ch)
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

uint64_t cam_peaks_set_point_q20(const cam_spindle_demand_t *demand, uint64_t c_q16)
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

cam_err_t cam_peaks_check(const cam_table_t *t)
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
