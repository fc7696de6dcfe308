// SPDX-License-Identifier: Apache-2.0
/// cam_eval: a channel's value and two derivatives, inline, constant time, cannot fail.
///
/// Two slices are blended knot by knot, then one quintic runs through the two blended knots, all in
/// the channel's LSB with four guard bits. The bounds that cam_table_check() enforces
/// (CAM_TABLE_SUM_MAX) keep every intermediate below 2^31; no segment, slice or angle can overflow.
///
/// Error against exact arithmetic on the same knots: below 1 LSB for the value, 2 LSB per knot
/// interval for the first and 8 LSB per interval^2 for the second derivative
/// (blending < 1/16 each knot member, Horner steps < 1/16 each, final rounding 1/2).
#ifndef CAM_EVAL_H
#define CAM_EVAL_H

#include "cam/cam_fix.h"   // cam_mulhi
#include "cam/cam_table.h" // cam_channel_t
#include <stdbool.h>       // bool

enum { cam_eval_guard_bits = 4 };
#define CAM_EVAL_GUARD (INT32_C(1) << cam_eval_guard_bits)

/// A function's value and derivatives with respect to the knot interval h.
typedef struct {
    int32_t y;       ///< [LSB] value
    int32_t d1;      ///< [LSB / h]
    int32_t d2;      ///< [LSB / h^2]
    bool is_clamped; ///< height outside the channel: evaluated at its edge
} cam_value_t;

/// A height between two slices.
typedef struct {
    uint32_t i;    ///< lower slice, 0 .. n_slices - 2
    int32_t w_q31; ///< weight of slice i + 1, 0 .. 2^31 - 1
    bool is_clamped;
} cam_height_t;

/// Find a height between slices by one multiplication.
/// @param ch    passed cam_table_check()
/// @param z_nm  [nm] any value
/// Context: ISR or slow side, constant time.
static inline cam_height_t cam_eval_height(const cam_channel_t *ch, int32_t z_nm)
{
    const bool is_below = z_nm < ch->z_first_nm;
    const uint32_t above_nm = (uint32_t)z_nm - (uint32_t)ch->z_first_nm; // right unless below
    const bool is_above = !is_below && above_nm > ch->span_nm;
    const uint32_t rel_nm = is_below ? 0u : is_above ? ch->span_nm : above_nm;
    const uint64_t slice_q48 = (uint64_t)rel_nm * ch->slices_per_nm_q48;
    const uint32_t i = (uint32_t)(slice_q48 >> 48);
    const bool is_last = i >= ch->n_slices - 1u; // the reciprocal is rounded: the end may reach it
    return (cam_height_t){
        .i = is_last ? ch->n_slices - 2u : i,
        .w_q31 = is_last ? INT32_MAX : (int32_t)((slice_q48 >> 17) & 0x7FFFFFFFu),
        .is_clamped = is_below || is_above,
    };
}

/// @return a + (b - a) w, in LSB / 16; |a|, |b| <= CAM_TABLE_SUM_MAX
static inline int32_t cam_eval_blend(int32_t a, int32_t b, int32_t w_q31)
{
    return a * CAM_EVAL_GUARD + cam_mulhi((b - a) * (2 * CAM_EVAL_GUARD), w_q31);
}

/// @return r t + c: one Horner step, |r| < 2^30
static inline int32_t cam_eval_step(int32_t r, int32_t t_q31, int32_t c)
{
    return c + cam_mulhi(r * 2, t_q31);
}

/// @return r rounded from LSB / 16 to LSB
static inline int32_t cam_eval_round(int32_t r)
{
    return (r + CAM_EVAL_GUARD / 2) >> cam_eval_guard_bits;
}

/// The quintic through two knots.
/// @param k0,k1  knots in LSB / 16, within the bounds of cam_table_check()
/// @param t_q31  [h / 2^31] 0 .. 2^31 - 1
/// Source: TABLE_FORMAT.md, "Knots".
static inline cam_value_t cam_eval_quintic(cam_knot_t k0, cam_knot_t k1, int32_t t_q31)
{
    const int32_t dp = k1.p - k0.p - k0.v - k0.a;
    const int32_t dv = k1.v - k0.v - 2 * k0.a;
    const int32_t da = k1.a - k0.a;
    const int32_t c3 = 10 * dp - 4 * dv + da;
    const int32_t c4 = -15 * dp + 7 * dv - 2 * da;
    const int32_t c5 = 6 * dp - 3 * dv + da;
    int32_t y = cam_eval_step(c5, t_q31, c4);
    y = cam_eval_step(y, t_q31, c3);
    y = cam_eval_step(y, t_q31, k0.a);
    y = cam_eval_step(y, t_q31, k0.v);
    y = cam_eval_step(y, t_q31, k0.p);
    int32_t d1 = cam_eval_step(5 * c5, t_q31, 4 * c4);
    d1 = cam_eval_step(d1, t_q31, 3 * c3);
    d1 = cam_eval_step(d1, t_q31, 2 * k0.a);
    d1 = cam_eval_step(d1, t_q31, k0.v);
    int32_t d2 = cam_eval_step(20 * c5, t_q31, 12 * c4);
    d2 = cam_eval_step(d2, t_q31, 6 * c3);
    d2 = cam_eval_step(d2, t_q31, 2 * k0.a);
    return (cam_value_t){
        .y = cam_eval_round(y), .d1 = cam_eval_round(d1), .d2 = cam_eval_round(d2)};
}

/// @return both slices' knot at index k blended at a height, in LSB / 16
static inline cam_knot_t cam_eval_knot(const cam_knot_t *low, const cam_knot_t *high, int32_t w_q31)
{
    return (cam_knot_t){
        .p = cam_eval_blend(low->p, high->p, w_q31),
        .v = cam_eval_blend(low->v, high->v, w_q31),
        .a = cam_eval_blend(low->a, high->a, w_q31),
    };
}

/// @return a stored knot in LSB / 16
static inline cam_knot_t cam_eval_guarded(const cam_knot_t *k)
{
    return (cam_knot_t){
        .p = k->p * CAM_EVAL_GUARD, .v = k->v * CAM_EVAL_GUARD, .a = k->a * CAM_EVAL_GUARD};
}

/// Evaluate a channel over angle and height.
/// @param ch         passed cam_table_check(), kind u
/// @param theta_q32  [turn / 2^32] any value, 0 = long axis
/// @param z_nm       [nm] any value
/// @return           derivatives per knot interval of 2^-(log2_knots + log2_repeat) turn
/// Context: ISR or slow side, constant time. Source: TABLE_FORMAT.md.
static inline cam_value_t cam_eval_surface(const cam_channel_t *ch, uint32_t theta_q32,
                                           int32_t z_nm)
{
    const cam_height_t z = cam_eval_height(ch, z_nm);
    const uint32_t pattern_q32 = theta_q32 << ch->log2_repeat;
    const uint32_t n_knots = 1u << ch->log2_knots;
    const uint32_t k = pattern_q32 >> (32u - ch->log2_knots);
    const uint32_t k_next = (k + 1u) & (n_knots - 1u);
    const int32_t t_q31 = (int32_t)((pattern_q32 << ch->log2_knots) >> 1);
    const cam_knot_t *low = ch->knots + ((size_t)z.i << ch->log2_knots);
    const cam_knot_t *high = low + n_knots;
    cam_value_t value =
        cam_eval_quintic(cam_eval_knot(low + k, high + k, z.w_q31),
                         cam_eval_knot(low + k_next, high + k_next, z.w_q31), t_q31);
    value.is_clamped = z.is_clamped;
    return value;
}

/// Evaluate a channel over height alone.
/// @param ch    passed cam_table_check(), kind x
/// @param z_nm  [nm] any value
/// @return      derivatives per slice spacing
/// Context: ISR or slow side, constant time. Source: TABLE_FORMAT.md.
static inline cam_value_t cam_eval_profile(const cam_channel_t *ch, int32_t z_nm)
{
    const cam_height_t z = cam_eval_height(ch, z_nm);
    const cam_knot_t *k = ch->knots + z.i;
    cam_value_t value = cam_eval_quintic(cam_eval_guarded(k), cam_eval_guarded(k + 1), z.w_q31);
    value.is_clamped = z.is_clamped;
    return value;
}

#endif
