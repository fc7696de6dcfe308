// SPDX-License-Identifier: Apache-2.0
/// cam_speed: the spindle's speed as a function of its angle, for a constant removal rate.
///
///     speed = mean * r,   r = 1 + envelope * (ratio(angle, Z) - 1)
///     acceleration = mean^2 * r * dr/dangle
///     set-point = mean * (r + r * dr/dturn * L),   L = turns of mean speed in one spindle lag
///
/// The set-point is the inverse of a speed loop of first order, so the spindle itself follows r,
/// MATHS.md (57).
/// Inline, constant time, cannot fail. Context: ISR unless noted.
#ifndef CAM_SPEED_H
#define CAM_SPEED_H

#include "cam_eval.h"  // cam_eval_surface
#include "cam_fix.h"   // cam_clamp_i64
#include "cam_table.h" // cam_channel_t
#include <stdint.h>    // int32_t, int64_t

/// Configuration, made by cam_config_build().
typedef struct {
    int32_t mean_mrpm;     ///< [r/min / 1000] > 0
    int32_t limit_mrpm;    ///< [r/min / 1000] highest set-point
    int32_t sense;         ///< +1 or -1: sign of the set-point while cutting
    int32_t lag_turns_q24; ///< [turn] L
    int64_t mean2_q48;     ///< [turn^2 / tick^2] square of the mean speed, below 2^37
} cam_speed_config_t;

/// Ratio at an angle.
typedef struct {
    int32_t ratio_q28; ///< [1] 1/16 .. 4
    int32_t slope_q20; ///< [1 / turn]
} cam_ratio_t;

/// What the spindle shall do.
typedef struct {
    int32_t spindle_mrpm; ///< [r/min / 1000] set-point, signed
    int32_t alpha_q40;    ///< [turn / 2^40 per tick^2] acceleration in the sense of cutting
} cam_speed_t;

/// One in the ratio's format.
#define CAM_RATIO_ONE_Q28 (INT32_C(1) << 28)

/// Ratio and slope in their own units.
/// @param ch     passed cam_table_check(), kind speed: a ratio of 1/16 .. 4
/// @param value  of that channel
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
/// Context: ISR or slow side. Error: 2 LSB of the channel, 2 LSB per knot interval of the slope.
static inline cam_ratio_t cam_speed_ratio(const cam_channel_t *ch, uint32_t theta_q32, int32_t z_nm)
{
    return cam_speed_scaled(ch, cam_eval_surface(ch, theta_q32, z_nm));
}

/// What of the ratio is in force at an envelope.
typedef struct {
    int32_t r_q28;      ///< [1] 1/16 .. 4
    int32_t change_q20; ///< [1 / turn] r dr/dturn, limited to 64, which cam_table_check() demands
} cam_pace_t;

/// @param ratio         of the table
/// @param envelope_q30  [1 / 2^30] 0 out of the work, 2^30 at full depth
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

/// @return [1 / 2^28] 0 .. 8, share of the mean speed that the spindle is told
static inline uint32_t cam_speed_told_q28(const cam_speed_config_t *cfg, cam_pace_t pace)
{
    const int64_t set_q28 = pace.r_q28 + (((int64_t)pace.change_q20 * cfg->lag_turns_q24) >> 16);
    return (uint32_t)cam_clamp_i64(set_q28, 0, INT64_C(8) * CAM_RATIO_ONE_Q28);
}

/// @return [r/min / 1000] set-point, signed
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
