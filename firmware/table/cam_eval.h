// SPDX-License-Identifier: Apache-2.0
/// cam_eval: looks up a checked table, inline, in constant time, cannot fail.
///
/// Read the evaluation of a channel first; the parts after it, the feed, the lobes and the speed of
/// the spindle, give the values of a channel their meaning.
///
/// A channel's value and two derivatives take three steps: find the slices below and above the
/// height (cam_eval_height), blend their knots before and after the angle by the height
/// (cam_eval_segment), and evaluate the quintic through the two blended knots (cam_eval_quintic).
/// All in the channel's LSB with four guard bits. The quintic is expanded about the middle of its
/// interval, so that its variable is a signed fraction that a rounded multiplication takes
/// directly. The bounds of cam_table_check() (CAM_TABLE_SUM_MAX) keep every intermediate result
/// below 2^31.
///
/// If memory changes a knot after the check, sums wrap, but no access leaves the table: indices
/// follow from angle, height and the checked sizes. The guard checks the result in the tick that
/// would use it, and the background check finds the change (FAULTS.md).
/// Context of all functions: ISR or slow side, constant time. Source: TABLE_FORMAT.md.
///
/// Error against exact arithmetic on the same knots, MATHS.md (49): below 1 LSB for the value,
/// 2 LSB per knot interval for the first and 8 LSB per interval^2 for the second derivative.
/// Blending contributes less than 1/16 LSB per knot member, each Horner step less than 1/32, the
/// final rounding 1/2.
#ifndef CAM_EVAL_H
#define CAM_EVAL_H

#include "cam_fix.h"   // cam_mulhi_add, cam_wrap_add, cam_clamp_i64
#include "cam_table.h" // cam_channel_t, cam_table_t
#include <stdbool.h>   // bool
#include <stddef.h>    // size_t
#include <stdint.h>    // int32_t, int64_t, uint32_t

/// Inlines a function, so that structures it returns stay in registers.
#define CAM_EVAL_INLINE static inline __attribute__((always_inline))

/// Fraction bits below the LSB of intermediate results, and one LSB with them.
enum { cam_eval_guard_bits = 4 };
#define CAM_EVAL_GUARD (INT32_C(1) << cam_eval_guard_bits)

/// Value and derivatives of a channel with respect to the knot interval h, in LSB of the channel
/// or, before rounding, in LSB / 16; below 2^30.
typedef struct {
    int32_t y;  ///< [LSB] value
    int32_t d1; ///< [LSB / h]
    int32_t d2; ///< [LSB / h^2]
} cam_value_t;

/// A height between two slices.
typedef struct {
    uint32_t i;    ///< lower slice, 0 .. n_slices - 2
    int32_t w_q31; ///< weight of slice i + 1, 0 .. 2^31 - 1
} cam_height_t;

/// A segment at one height: two knots and the position between them.
typedef struct {
    cam_knot_t k0; ///< [LSB / 16], likewise the next one
    cam_knot_t k1;
    int32_t s_q32; ///< [h / 2^32] distance from the middle of the interval
} cam_segment_t;

/// Find a height between two slices by the stored reciprocal of their spacing.
/// @param ch    passed cam_table_check()
/// @param z_nm  [nm] any value; outside the channel its edge is taken
/*@ requires slices: \valid_read(ch) && 2 <= ch->n_slices <= 4096;
    assigns \result \from indirect: *ch, indirect: z_nm;
    ensures slice: \result.i <= ch->n_slices - 2;
    ensures most: \result.i <= 4094;
    ensures weight: 0 <= \result.w_q31;
*/
CAM_EVAL_INLINE cam_height_t cam_eval_height(const cam_channel_t *ch, int32_t z_nm)
{
    const uint32_t above_nm =
        z_nm < ch->z_first_nm ? 0u : (uint32_t)z_nm - (uint32_t)ch->z_first_nm;
    const uint32_t rel_nm = above_nm < ch->span_nm ? above_nm : ch->span_nm;
    const uint64_t slice_q48 = (uint64_t)rel_nm * ch->slices_per_nm_q48;
    const uint32_t i = (uint32_t)(slice_q48 >> 48);
    const uint32_t last = ch->n_slices - 1u; // the rounded reciprocal may reach it at the end
    return (cam_height_t){
        .i = i < last ? i : last - 1u,
        .w_q31 = i < last ? (int32_t)((slice_q48 >> 17) & 0x7FFFFFFFu) : INT32_MAX,
    };
}

/// Blend two numbers of a knot.
/// @param a, b   [LSB] magnitudes up to CAM_TABLE_SUM_MAX
/// @param w_q31  weight of b, 0 .. 2^31 - 1
/// @return       [LSB / 16] a + (b - a) w
//@ assigns \result \from a, b, w_q31;
static inline int32_t cam_eval_blend(int32_t a, int32_t b, int32_t w_q31)
{
    return cam_mulhi_add(cam_wrap_times(a, CAM_EVAL_GUARD),
                         cam_wrap_times(cam_wrap_sub(b, a), 2 * CAM_EVAL_GUARD), w_q31);
}

/// @return r rounded from LSB / 16 to whole LSB, half up
/*@ assigns \result \from r;
    ensures nearest: r <= INT32_MAX - 8 ==> 16 * \result - 8 <= r < 16 * \result + 8;
*/
static inline int32_t cam_eval_round(int32_t r)
{
    return cam_wrap_add(r, CAM_EVAL_GUARD / 2) >> cam_eval_guard_bits;
}

/// Evaluate the quintic through two knots about the middle of its interval,
/// q(s) = e0 + o1 s + e2 s^2 + o3 s^3 + e4 s^4 + o5 s^5, by three Horner schemes at once: each uses
/// the running value of the previous one.
/// With w = v0 + v1 - 2 (p1 - p0): o5 = (a1 - a0) - 3 w, o3 = w - o5 / 2,
/// o1 = (p1 - p0) - o3 / 4 - o5 / 16; and with dv = v1 - v0: e4 = (a0 + a1 - dv) / 2,
/// e2 = (dv - e4) / 2, e0 = (p0 + p1) / 2 - e2 / 4 - e4 / 16.
/// @param at  knots within the bounds of cam_table_check(), any s_q32
/// @return    [LSB / 16] before rounding. Source: MATHS.md (46), (47).
//@ assigns \result \from at;
CAM_EVAL_INLINE cam_value_t cam_eval_quintic(cam_segment_t at)
{
    const int32_t s_q32 = at.s_q32;
    const int32_t dp = cam_wrap_sub(at.k1.p, at.k0.p);
    const int32_t dv = cam_wrap_sub(at.k1.v, at.k0.v);
    const int32_t w = cam_wrap_sub(cam_wrap_add(at.k0.v, at.k1.v), cam_wrap_times(dp, 2));
    const int32_t o5 = cam_wrap_sub(cam_wrap_sub(at.k1.a, at.k0.a), cam_wrap_times(w, 3));
    const int32_t o3 = cam_wrap_sub(w, o5 >> 1);
    const int32_t o1 = cam_wrap_sub(dp, (o3 >> 2) + (o5 >> 4));
    const int32_t e4 = cam_wrap_sub(cam_wrap_add(at.k0.a, at.k1.a), dv) >> 1;
    const int32_t e2 = cam_wrap_sub(dv, e4) >> 1;
    const int32_t e0 = cam_wrap_sub(cam_wrap_add(at.k0.p, at.k1.p) >> 1, (e2 >> 2) + (e4 >> 4));
    int32_t y = cam_mulhi_add(e4, o5, s_q32);
    int32_t d1 = cam_mulhi_add(y, o5, s_q32);
    int32_t d2 = cam_mulhi_add(d1, o5, s_q32);
    y = cam_mulhi_add(o3, y, s_q32);
    d1 = cam_mulhi_add(y, d1, s_q32);
    d2 = cam_mulhi_add(d1, d2, s_q32);
    y = cam_mulhi_add(e2, y, s_q32);
    d1 = cam_mulhi_add(y, d1, s_q32);
    d2 = cam_mulhi_add(d1, d2, s_q32);
    y = cam_mulhi_add(o1, y, s_q32);
    d1 = cam_mulhi_add(y, d1, s_q32);
    y = cam_mulhi_add(e0, y, s_q32);
    return (cam_value_t){.y = y, .d1 = d1, .d2 = cam_wrap_times(d2, 2)};
}

/// @return value and derivatives rounded to whole LSB
static inline cam_value_t cam_eval_rounded(cam_value_t fine)
{
    return (cam_value_t){
        .y = cam_eval_round(fine.y), .d1 = cam_eval_round(fine.d1), .d2 = cam_eval_round(fine.d2)};
}

/// @return [LSB / 16] knot of the lower and of the upper slice, blended; w_q31 as of
/// cam_eval_blend()
CAM_EVAL_INLINE cam_knot_t cam_eval_knot(const cam_knot_t *low, const cam_knot_t *high,
                                         int32_t w_q31)
{
    return (cam_knot_t){
        .p = cam_eval_blend(low->p, high->p, w_q31),
        .v = cam_eval_blend(low->v, high->v, w_q31),
        .a = cam_eval_blend(low->a, high->a, w_q31),
    };
}

/// @return [LSB / 16] a stored knot with guard bits
static inline cam_knot_t cam_eval_guarded(const cam_knot_t *k)
{
    return (cam_knot_t){.p = cam_wrap_times(k->p, CAM_EVAL_GUARD),
                        .v = cam_wrap_times(k->v, CAM_EVAL_GUARD),
                        .a = cam_wrap_times(k->a, CAM_EVAL_GUARD)};
}

/// Find the segment of a channel over angle at an angle and a height, for cam_eval_quintic(), whose
/// derivatives are then per knot interval of 2^-(log2_knots + log2_repeat) turn.
/// @param ch         passed cam_table_check(), any kind but x and way
/// @param theta_q32  [turn / 2^32] any value, 0 = long axis
/// @param z          result of cam_eval_height() for the same channel
CAM_EVAL_INLINE cam_segment_t cam_eval_segment(const cam_channel_t *ch, uint32_t theta_q32,
                                               cam_height_t z)
{
    const uint32_t pattern_q32 = theta_q32 << ch->log2_repeat;
    const uint32_t n_knots = 1u << ch->log2_knots;
    const uint32_t k = pattern_q32 >> (32u - ch->log2_knots);
    const uint32_t k_next = (k + 1u) & (n_knots - 1u);
    const cam_knot_t *low = ch->knots + ((size_t)z.i << ch->log2_knots);
    const cam_knot_t *high = low + n_knots;
    return (cam_segment_t){
        .k0 = cam_eval_knot(low + k, high + k, z.w_q31),
        .k1 = cam_eval_knot(low + k_next, high + k_next, z.w_q31),
        .s_q32 = (int32_t)((pattern_q32 << ch->log2_knots) ^ 0x80000000u),
    };
}

/// Evaluate a channel over angle at a height. Arguments as of cam_eval_segment().
/// @return  derivatives per knot interval of 2^-(log2_knots + log2_repeat) turn
static inline cam_value_t cam_eval_surface_at(const cam_channel_t *ch, uint32_t theta_q32,
                                              cam_height_t z)
{
    return cam_eval_rounded(cam_eval_quintic(cam_eval_segment(ch, theta_q32, z)));
}

/// Evaluate a channel over height alone.
/// @param ch    passed cam_table_check(), kind x or way
/// @param z_nm  [nm] any value
/// @return      derivatives per slice spacing
static inline cam_value_t cam_eval_profile(const cam_channel_t *ch, int32_t z_nm)
{
    const cam_height_t z = cam_eval_height(ch, z_nm);
    const cam_knot_t *below = ch->knots + z.i;
    const cam_segment_t segment = {
        .k0 = cam_eval_guarded(below),
        .k1 = cam_eval_guarded(below + 1),
        .s_q32 = (int32_t)(((uint32_t)z.w_q31 << 1) ^ 0x80000000u),
    };
    return cam_eval_rounded(cam_eval_quintic(segment));
}

/// The feed as a function of height: the lead of Z over a plain helix.
///
///     Z = z + way(z),  z the height of the plain helix after the same number of turns
///
/// way is 0 at both ends of the table, and 1 + dway/dz, the feed over its mean, is positive, so
/// that Z never reverses. With stations z counts the turns: Z stands while X feeds in or out, goes
/// back between two passes, and stays between its first and its last height. Source:
/// TABLE_FORMAT.md, "Way" and "Stations"; MATHS.md (103), (104).

/// Position and feed on the profile.
typedef struct {
    int32_t z_nm;      ///< [nm] height of Z
    int32_t slope_q16; ///< [1 / 2^16] feed over its mean
} cam_feed_profile_t;

/// @param table  with a way
/// @param z_nm   [nm] height of the plain helix
/// @return       Z with an error below 1 nm; its feed is below 2^14 times the mean
static inline cam_feed_profile_t cam_feed_profile_at(const cam_table_t *table, int32_t z_nm)
{
    const cam_channel_t *way = &table->way;
    const cam_value_t ahead = cam_eval_profile(way, z_nm);
    const int32_t half = (int32_t)((UINT32_C(1) << way->frac_bits) >> 1);
    const int64_t slope_q16 =
        ((int64_t)ahead.d1 * way->slices_per_nm_q48) >> (32u + way->frac_bits);
    return (cam_feed_profile_t){
        .z_nm = cam_wrap_add(z_nm, ((ahead.y + half) >> way->frac_bits) + way->value_offset),
        .slope_q16 = cam_sat_i32(slope_q16 + 65536),
    };
}

/// @return [nm] Z at the end of the table
static inline int32_t cam_feed_profile_z_last_nm(const cam_table_t *t)
{
    return t->has_stations ? cam_feed_profile_at(t, t->z_last_nm).z_nm : t->z_last_nm;
}

/// The lobes of a shaft, each of which plays a pattern that several may share. In such a table a
/// slice is the pattern of a profile, not a height. At any height the nearest lobe is played: its
/// pattern, turned by its phase. From 20 um beyond a lobe's edge its lift falls by a smooth step;
/// it is 0 in the middle of the gap, where the next lobe takes over. Source: TABLE_FORMAT.md,
/// "Lobes".

enum { cam_lobes_kept_off_nm = 20000 }; ///< [nm] the full lift extends this far beyond a lobe

/// @param t     with lobes
/// @param z_nm  [nm] any value
/// @return      index of the lobe that is played there
uint32_t cam_lobes_find(const cam_table_t *t, int32_t z_nm);

/// @param i     a lobe
/// @param z_nm  [nm] any value
/// @return      [1 / 2^31] progress of the change to the neighbouring lobe: 0 on lobe i,
///              2^31 - 1 in the middle of the gap and beyond
int32_t cam_lobes_change_q31(const cam_table_t *t, uint32_t i, int32_t z_nm);

/// @param n_slices  of a channel over angle, at least 2
/// @param pattern   0 .. n_slices - 1
/// @return          the slice of that pattern, not blended with another
/*@ requires slices: 2 <= n_slices <= 4096;
    assigns \result \from indirect: n_slices, indirect: pattern;
    ensures slice: \result.i <= n_slices - 2;
    ensures most: \result.i <= 4094;
    ensures weight: 0 <= \result.w_q31;
*/
static inline cam_height_t cam_lobes_slice(uint32_t n_slices, uint32_t pattern)
{
    const uint32_t last = n_slices - 1u;
    return (cam_height_t){.i = pattern < last ? pattern : last - 1u,
                          .w_q31 = pattern < last ? 0 : INT32_MAX};
}

/// The spindle's speed as a function of its angle (equal-volume cutting). A table may hold the
/// ratio of the spindle's speed to its mean speed, so that the removal rate is the same all around
/// an oval. The envelope rises from 0 to 1 while the tool engages:
///
///     speed = mean * r,   r = 1 + envelope * (ratio(angle, Z) - 1)
///
/// Between two plans (cam_plan.h), a period T apart, r rises linearly from r0 to r1, so the speed
/// is right at every plan. The set-point inverts a first-order speed loop with the time constant
/// lag, so that the spindle itself follows r, MATHS.md (57):
///
///     acceleration = mean * (r1 - r0) / T
///     set-point = mean * ((r0 + r1) / 2 + (r1 - r0) * lag / T)

/// Configuration, built from the parameters.
typedef struct {
    int32_t mean_mrpm;  ///< [r/min / 1000] > 0
    int32_t limit_mrpm; ///< [r/min / 1000] highest set-point
    int32_t sense;      ///< +1 or -1: sign of the set-point while cutting
    int32_t lag_q16;    ///< [plans / 2^16] time constant of the speed loop
    int32_t mean_q32;   ///< [turn / 2^32 per tick] mean speed, at most 2^26
} cam_speed_config_t;

/// @param rate_q30  [1] override of the spindle, 1/2 .. 5/4
/// @return          the configuration with another mean speed
static inline cam_speed_config_t cam_speed_overridden(const cam_speed_config_t *cfg,
                                                      int32_t rate_q30)
{
    cam_speed_config_t c = *cfg;
    c.mean_mrpm = cam_mul_shift(cfg->mean_mrpm, rate_q30, 30);
    c.mean_q32 = cam_mul_shift(cfg->mean_q32, rate_q30, 30);
    return c;
}

/// Speed ratio at an angle.
typedef struct {
    int32_t ratio_q28; ///< [2^-28] speed over mean speed, 1/16 .. 4
    int32_t slope_q20; ///< [1 / turn / 2^20] its derivative over the angle
} cam_ratio_t;

/// The ratio 1 in q28.
#define CAM_RATIO_ONE_Q28 (INT32_C(1) << 28)

/// @param ch  passed cam_table_check(), kind speed: a ratio of 1/16 .. 4
/// @param y   of that channel, rounded
/// @return    [2^-28] the ratio
static inline int32_t cam_speed_ratio_q28(const cam_channel_t *ch, int32_t y)
{
    const int32_t above_q28 = (int32_t)((uint32_t)y << (8u - ch->frac_bits));
    return cam_wrap_add(ch->value_offset * 256, above_q28);
}

/// Convert a value of a speed channel to the formats of cam_ratio_t.
/// @param ch     passed cam_table_check(), kind speed
/// @param value  of that channel, as cam_eval_surface_at() returns it
static inline cam_ratio_t cam_speed_scaled(const cam_channel_t *ch, cam_value_t value)
{
    const uint32_t shift = ch->log2_knots + ch->log2_repeat;
    return (cam_ratio_t){
        .ratio_q28 = cam_speed_ratio_q28(ch, value.y),
        .slope_q20 = cam_sat_i32(((int64_t)value.d1 * (INT64_C(1) << shift)) >> ch->frac_bits),
    };
}

/// Evaluate a speed channel.
/// @param ch          passed cam_table_check(), kind speed
/// @param theta_q32   [turn / 2^32] any value, 0 = long axis
/// @param z           of the same channel: cam_eval_height() or cam_lobes_slice()
/// @return            ratio within 2 LSB of the channel, slope within 2 LSB per knot interval
static inline cam_ratio_t cam_speed_ratio_at(const cam_channel_t *ch, uint32_t theta_q32,
                                             cam_height_t z)
{
    return cam_speed_scaled(ch, cam_eval_surface_at(ch, theta_q32, z));
}

/// The ratio of cam_speed_ratio_at() in fewer instructions, without its slope.
CAM_EVAL_INLINE int32_t cam_speed_ratio_q28_at(const cam_channel_t *ch, uint32_t theta_q32,
                                               cam_height_t z)
{
    const int32_t y = cam_eval_quintic(cam_eval_segment(ch, theta_q32, z)).y;
    return cam_speed_ratio_q28(ch, cam_eval_round(y));
}

/// Blend from uniform speed to the ratio of the table.
/// @param ratio_q28     [2^-28] ratio of the table
/// @param envelope_q30  [2^-30] 0: uniform (tool out of the work), 2^30: ratio of the table
/// @return              [2^-28] ratio in force, 1/16 .. 4
static inline int32_t cam_speed_eased_q28(int32_t ratio_q28, int32_t envelope_q30)
{
    const int32_t above_q28 = ratio_q28 - CAM_RATIO_ONE_Q28;
    return CAM_RATIO_ONE_Q28 + (int32_t)(((int64_t)above_q28 * envelope_q30) >> 30);
}

/// Set-point from one plan to the next.
/// @param from_q28,to_q28  [2^-28] r0 and r1, 1/16 .. 4
/// @return                 [r/min / 1000] set-point, signed, limited to limit_mrpm
static inline int32_t cam_speed_mrpm(const cam_speed_config_t *cfg, int32_t from_q28,
                                     int32_t to_q28)
{
    const int64_t middle_q28 = ((int64_t)from_q28 + to_q28) >> 1;
    const int64_t set_q28 = middle_q28 + (((int64_t)(to_q28 - from_q28) * cfg->lag_q16) >> 16);
    const int64_t limited_q28 = cam_clamp_i64(set_q28, 0, INT64_C(8) * CAM_RATIO_ONE_Q28 - 1);
    const int64_t mrpm = (limited_q28 * cfg->mean_mrpm) >> 28;
    return (int32_t)cam_clamp_i64(mrpm, 0, cfg->limit_mrpm) * cfg->sense;
}

/// @param step_q28  [1 per tick] of the ratio
/// @return          [turn / 2^40 per tick^2] acceleration in the sense of cutting, saturated
static inline int32_t cam_speed_alpha_q40(const cam_speed_config_t *cfg, int32_t step_q28)
{
    return cam_sat_i32(((int64_t)cfg->mean_q32 * step_q28) >> 20);
}

#endif
