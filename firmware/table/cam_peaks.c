// SPDX-License-Identifier: Apache-2.0
#include "cam_peaks.h"
#include "cam_bounds.h" // cam_bounds_add
#include "cam_eval.h"   // cam_eval_profile
#include "cam_fix.h"    // cam_abs_i64

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

/// @return v >= 0 limited to the range of uint32
static uint32_t saturated(int64_t v)
{
    return v < (int64_t)UINT32_MAX ? (uint32_t)v : UINT32_MAX;
}

/// @return knot intervals per turn
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
        const cam_knot_t *at = &ch->knots[i];
        const cam_knot_t *next = &ch->knots[cam_bounds_next(ch, i)];
        const cam_wide_knot_t k0 = {at->p + offset, at->v, at->a};
        const cam_wide_knot_t k1 = {next->p + offset, next->v, next->a};
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
        const cam_knot_t *at = &ch->knots[i];
        const cam_knot_t *next = &ch->knots[cam_bounds_next(ch, i)];
        const cam_wide_knot_t k0 = {at->p, at->v, at->a};
        const cam_wide_knot_t k1 = {next->p, next->v, next->a};
        cam_bounds_add_third(&b, &k0, &k1);
    }
    return in_unit(ch,
                   derivative_per_rad(ch, derivative_per_rad(ch, derivative_per_rad(ch, b.third))));
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
/// @return               [1e-6] its magnitude as a slope
static uint64_t slope_ppm(const cam_channel_t *x, int64_t per_slice_lsb)
{
    const uint64_t rise = (uint64_t)cam_abs_i64(per_slice_lsb) * 1000000u * (x->n_slices - 1u);
    return (rise >> x->frac_bits) / x->span_nm;
}

/// @param per_slice_ppm  [1e-6 per slice]
/// @return               [1e-6 / m] UINT32_MAX where the product would overflow
static uint64_t bend_ppm_per_m(const cam_channel_t *x, uint64_t per_slice_ppm)
{
    const uint64_t most_ppm = UINT64_C(1) << 21; // 2^21 10^9 2^12 < 2^63
    return per_slice_ppm < most_ppm ? per_slice_ppm * 1000000000u * (x->n_slices - 1u) / x->span_nm
                                    : UINT32_MAX;
}

static void raise_to(uint32_t *most, uint64_t value)
{
    const uint32_t held = value < UINT32_MAX ? (uint32_t)value : UINT32_MAX;
    *most = held > *most ? held : *most;
}

cam_x_slope_t cam_x_slope_of(const cam_channel_t *x)
{
    const uint32_t n = (x->n_slices - 1u) * (uint32_t)samples_per_slice;
    cam_x_slope_t most = {0};
    for (uint32_t i = 0; i <= n; i++) {
        const int32_t up_nm = (int32_t)((uint64_t)x->span_nm * i / n);
        const cam_value_t at = cam_eval_profile(x, x->z_first_nm + up_nm);
        const uint64_t slope = slope_ppm(x, at.d1);
        raise_to(&most.slope_ppm, slope);
        raise_to(&most.rise_ppm, at.d1 > 0 ? slope : 0u);
        raise_to(&most.bend_ppm_per_m, bend_ppm_per_m(x, slope_ppm(x, at.d2)));
    }
    return most;
}
