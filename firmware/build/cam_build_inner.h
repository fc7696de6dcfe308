// SPDX-License-Identifier: Apache-2.0
/// cam_build_inner: parts of cam_build_config(), and parameters in the units of the interrupt,
/// private to this room. Context: slow side.
#ifndef CAM_BUILD_INNER_H
#define CAM_BUILD_INNER_H

#include "cam_build.h"  // cam_units_scale
#include "cam_config.h" // cam_config_t
#include "cam_err.h"    // CAM_MUST_USE
#include "cam_fix.h"    // cam_sat_i32, CAM_TURN_Q32
#include "cam_param.h"  // cam_params_t, cam_refusal_t
#include <stdint.h>     // int32_t, int64_t, uint32_t

/// [nm / 1024] Rounding margin of set-point checks, which also allow 1/16 for encoder noise.
#define CAM_BUILD_MARGIN_Q10 3072

/// Derive the limits of all axes with their jerk windows: approach, retract and axis commands.
/// Requires the gains of the feed-forward, the spindle and the feed.
void cam_build_motion(cam_config_t *config, const cam_params_t *params, uint32_t tick_hz);

/// Derive the limits of jogging. Call after cam_build_motion().
void cam_build_jog(cam_config_t *config, const cam_params_t *params, uint32_t tick_hz);

/// Derive the position loop of a U that takes forces, and its supervision without the travel.
/// @return as cam_servo_setup()
CAM_MUST_USE cam_refusal_t cam_build_force(cam_force_config_t *c, const cam_params_t *params,
                                           uint32_t tick_hz);

/// @return [turn / 2^32] of micro-degrees
static inline int32_t cam_units_turn_of_udeg(int32_t udeg)
{
    const int64_t magnitude = cam_units_scale(cam_abs_i64(udeg), CAM_TURN_Q32, 360000000);
    return (int32_t)(uint32_t)(uint64_t)(udeg < 0 ? -magnitude : magnitude); // +180 deg is -2^31
}

/// @return [ticks / 2^16] of nanoseconds, saturated
static inline int32_t cam_units_ticks_of_ns(int32_t ns, uint32_t tick_hz)
{
    return cam_sat_i32(cam_units_scale(ns, (int64_t)tick_hz * 65536, 1000000000));
}

/// @return [ticks^2 / 2^16] of square microseconds within cam_derived_limits_check();
///         2^16 / 10^12 is reduced
static inline int32_t cam_units_ticks2_of_us2(int32_t us2, uint32_t tick_hz)
{
    return cam_sat_i32(cam_units_scale((int64_t)us2 * tick_hz, (int64_t)tick_hz * 16, 244140625));
}

/// @return [turn / 2^32] of thousandths of a degree below 90 degrees
static inline int32_t cam_units_turn_of_mdeg(int32_t mdeg)
{
    return (int32_t)cam_units_scale(mdeg, CAM_TURN_Q32, 360000);
}

#endif
