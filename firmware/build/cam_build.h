// SPDX-License-Identifier: Apache-2.0
/// cam_build: configuration of the interrupt from parameters and table, with all divisions and the
/// checks against the tick rate. Context: slow side.
#ifndef CAM_BUILD_H
#define CAM_BUILD_H

#include "cam_config.h" // cam_config_t
#include "cam_err.h"    // CAM_MUST_USE
#include "cam_fix.h"    // cam_sat_i32, CAM_TURN_Q32
#include "cam_param.h"  // cam_params_t, cam_refusal_t
#include "cam_table.h"  // cam_table_t
#include <stdint.h>     // int32_t, int64_t, uint32_t

/// Derive a configuration.
/// @param config      result, on success complete but for cam_config_learn()
/// @param params      within their ranges
/// @param table       NULL when none is selected
/// @param speed_limit_mrpm  [r/min / 1000] limit of the fault overspeed
/// @param tick_hz,clock_hz  [Hz] of the port
/// @return cam_ok, or the refusal of cam_derived_limits_check() or cam_servo_setup()
CAM_MUST_USE cam_refusal_t cam_build_config(cam_config_t *config, const cam_params_t *params,
                                            const cam_table_t *table, uint32_t speed_limit_mrpm,
                                            uint32_t tick_hz, uint32_t clock_hz);

/// Shift the targets in X and Z by the offset of the part; set-points stay in port coordinates.
/// Call once after cam_build_config(). Source: MATHS.md (170).
/// @param x_nm, z_nm  [nm] port coordinates of the part's origin
void cam_build_origin(cam_config_t *config, int32_t x_nm, int32_t z_nm);

/// @return [turns] at full amplitude before the feed begins: after a rehearsal the integral of U's
///         drive settles. None where Z is fed by others.
static inline int32_t cam_build_settle_turns(const cam_params_t *params)
{
    return params->rehearse_turns > 0 && params->z_is_measured == 0 ? 12 : 0;
}

/// @return [turn / 2^32 per tick] of a speed, rounded, saturated
int32_t cam_build_speed_q32(uint32_t speed_mrpm, uint32_t tick_hz);

/// @return a * b / c rounded to nearest; a * b must fit 62 bits; a, b >= 0, c > 0
static inline int64_t cam_units_scale(int64_t a, int64_t b, int64_t c)
{
    return (a * b + c / 2) / c;
}

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
