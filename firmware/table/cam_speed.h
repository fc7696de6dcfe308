// SPDX-License-Identifier: Apache-2.0
/// cam_speed: the spindle's speed as a function of its angle (equal-volume cutting).
///
/// A table may hold the ratio of the spindle's speed to its mean speed, so that the removal rate is
/// the same all around an oval. The envelope rises from 0 to 1 while the tool engages:
///
///     speed = mean * r,   r = 1 + envelope * (ratio(angle, Z) - 1)
///
/// Between two plans (cam_plan.h), a period T apart, r rises linearly from r0 to r1, so the speed
/// is right at every plan. The set-point inverts a first-order speed loop with the time constant
/// lag, so that the spindle itself follows r, MATHS.md (57):
///
///     acceleration = mean * (r1 - r0) / T
///     set-point = mean * ((r0 + r1) / 2 + (r1 - r0) * lag / T)
///
/// Inline, constant time, cannot fail. Context: ISR or slow side.
#ifndef CAM_SPEED_H
#define CAM_SPEED_H

#include "cam_eval.h"    // cam_eval_surface_at
#include "cam_fix.h"     // cam_clamp_i64
#include "cam_channel.h" // cam_channel_t
#include <stdint.h>      // int32_t, int64_t

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

/// Convert a value of a speed channel to the formats of cam_ratio_t.
/// @param ch     passed cam_table_check(), kind speed: a ratio of 1/16 .. 4
/// @param value  of that channel, as cam_eval_surface_at() returns it
static inline cam_ratio_t cam_speed_scaled(const cam_channel_t *ch, cam_value_t value)
{
    const uint32_t shift = ch->log2_knots + ch->log2_repeat;
    const int32_t above_q28 = (int32_t)((uint32_t)value.y << (8u - ch->frac_bits));
    return (cam_ratio_t){
        .ratio_q28 = cam_wrap_add(ch->value_offset * 256, above_q28),
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
