// SPDX-License-Identifier: Apache-2.0
/// cam_units: parameters in the units of the interrupt. Context: slow side.
#ifndef CAM_UNITS_H
#define CAM_UNITS_H

#include "cam_angle.h" // CAM_TURN_Q32
#include "cam_fix.h"   // cam_sat_i32
#include <stdint.h>    // int32_t, int64_t, uint32_t

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
