// SPDX-License-Identifier: Apache-2.0
/// cam_speed: the spindle's speed as a function of its angle (equal-volume cutting).
///
/// A table may hold the ratio of the spindle's speed to its mean speed, so that the tool removes
/// the same volume in the same time all around an oval:
///
///     speed = mean * r,   r = 1 + envelope * (ratio(angle, Z) - 1)
///     acceleration = mean^2 * r * dr/dangle
///     set-point = mean * (r + r * dr/dturn * L),   L = turns of mean speed in one spindle lag
///
/// The set-point is the inverse of a speed loop of first order, so that the spindle itself follows
/// r, MATHS.md (57). The envelope rises from 0 to 1 while the tool engages.
/// Inline, constant time, cannot fail. Context: ISR unless noted.
#ifndef CAM_SPEED_H
#define CAM_SPEED_H

#include "cam_eval.h"  // cam_eval_surface
#include "cam_fix.h"   // cam_clamp_i64
#include "cam_table.h" // cam_channel_t
#include <stdint.h>    // int32_t, int64_t

/// Configuration, made by cam_config_build(); constant while it is in force.
typedef struct {
    int32_t mean_mrpm;     ///< [r/min / 1000] > 0
    int32_t limit_mrpm;    ///< [r/min / 1000] highest set-point
    int32_t sense;         ///< +1 or -1: sign of the set-point while cutting
    int32_t lag_turns_q24; ///< [turn / 2^24] L
    int64_t mean2_q48;     ///< [turn^2 / tick^2 / 2^48] square of the mean speed, below 2^37
} cam_speed_config_t;

/// Speed ratio at an angle.
typedef struct {
    int32_t ratio_q28; ///< [2^-28] speed over mean speed, 1/16 .. 4
    int32_t slope_q20; ///< [1 / turn / 2^20] its derivative over the angle
} cam_ratio_t;

/// Set-point of the spindle.
typedef struct {
    int32_t spindle_mrpm; ///< [r/min / 1000] set-point, signed
    int32_t alpha_q40;    ///< [turn / 2^40 per tick^2] acceleration in the sense of cutting
} cam_speed_t;

/// The ratio 1 in q28.
#define CAM_RATIO_ONE_Q28 (INT32_C(1) << 28)

/// Convert a value of a speed channel to the formats of cam_ratio_t.
/// @param ch     passed cam_table_check(), kind speed: a ratio of 1/16 .. 4
/// @param value  of that channel, as cam_eval_surface() returns it
static inline cam_ratio_t cam_speed_scaled(const cam_channel_t *ch, cam_value_t value)
{
    const uint32_t shift = ch->log2_knots + ch->log2_repeat;
    const int32_t above_q28 = (int32_t)((uint32_t)value.y << (8u - ch->frac_bits));
    return (cam_ratio_t){
        .ratio_q28 = cam_wrap_add(ch->offset_nm * 256, above_q28),
        .slope_q20 = cam_sat_i32(((int64_t)value.d1 * (INT64_C(1) << shift)) >> ch->frac_bits),
    };
}

/// Evaluate a speed channel.
/// @param ch          passed cam_table_check(), kind speed
/// @param theta_q32   [turn / 2^32] any value, 0 = long axis
/// @param z_nm        [nm] any value
/// @return            ratio within 2 LSB of the channel, slope within 2 LSB per knot interval
/// Context: ISR or slow side.
static inline cam_ratio_t cam_speed_ratio(const cam_channel_t *ch, uint32_t theta_q32, int32_t z_nm)
{
    return cam_speed_scaled(ch, cam_eval_surface(ch, theta_q32, z_nm));
}

/// The part of a ratio that is in force at an envelope.
typedef struct {
    int32_t r_q28; ///< [2^-28] r, 1/16 .. 4
    int32_t
        change_q20; ///< [1 / turn / 2^20] r dr/dturn, limited to +-64 as cam_table_check() demands
} cam_pace_t;

/// Blend from uniform speed to the ratio of the table.
/// @param ratio         of the table
/// @param envelope_q30  [2^-30] 0: uniform (tool out of the work), 2^30: ratio of the table
static inline cam_pace_t cam_speed_pace(cam_ratio_t ratio, int32_t envelope_q30)
{
    const int64_t most_q20 = INT64_C(64) << 20;
    const int32_t above_q28 = ratio.ratio_q28 - CAM_RATIO_ONE_Q28;
    const int32_t r_q28 = CAM_RATIO_ONE_Q28 + (int32_t)(((int64_t)above_q28 * envelope_q30) >> 30);
    const int32_t slope_q20 = (int32_t)(((int64_t)ratio.slope_q20 * envelope_q30) >> 30);
    const int64_t change_q20 = ((int64_t)r_q28 * slope_q20) >> 28;
    return (cam_pace_t){.r_q28 = r_q28,
                        .change_q20 = (int32_t)cam_clamp_i64(change_q20, -most_q20, most_q20)};
}

/// Compensate the lag of the spindle's speed loop.
/// @return [2^-28] 0 .. 8, commanded speed over mean speed
static inline uint32_t cam_speed_told_q28(const cam_speed_config_t *cfg, cam_pace_t pace)
{
    const int64_t set_q28 = pace.r_q28 + (((int64_t)pace.change_q20 * cfg->lag_turns_q24) >> 16);
    return (uint32_t)cam_clamp_i64(set_q28, 0, INT64_C(8) * CAM_RATIO_ONE_Q28);
}

/// @param told_q28  [2^-28] result of cam_speed_told_q28()
/// @return          [r/min / 1000] set-point, signed, limited to limit_mrpm
static inline int32_t cam_speed_mrpm(const cam_speed_config_t *cfg, uint32_t told_q28)
{
    const int64_t mrpm = ((int64_t)told_q28 * cfg->mean_mrpm) >> 28;
    return (int32_t)cam_clamp_i64(mrpm, 0, cfg->limit_mrpm) * cfg->sense;
}

/// @return [turn / 2^40 per tick^2] acceleration in the sense of cutting, saturated
static inline int32_t cam_speed_alpha_q40(const cam_speed_config_t *cfg, cam_pace_t pace)
{
    return cam_sat_i32((cfg->mean2_q48 * pace.change_q20) >> 28);
}

#endif
