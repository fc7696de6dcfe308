// SPDX-License-Identifier: Apache-2.0
/// fuzz_limits: the commands that a machine may get, computed from its parameters alone.
///
/// By arithmetic of its own, because the judge must not be the accused: no function of the firmware
/// that derives a limit is asked.
#ifndef FUZZ_LIMITS_H
#define FUZZ_LIMITS_H

#include "cam_param.h" // cam_params_t
#include "hal/hal.h"   // hal_n_axes
#include <stdint.h>    // int64_t, uint32_t

enum { fuzz_limits_steps = 64 }; ///< of a window, at most

typedef struct {
    double speed_nm[hal_n_axes];        ///< [nm per tick]
    double acceleration_nm[hal_n_axes]; ///< [nm per tick^2]
    double leave_nm[hal_n_axes]; ///< [nm per tick] no slower than this an axis leaves the work
    double brake_nm[hal_n_axes]; ///< [nm per tick^2] no more gently than this it does
    double window[hal_n_axes];   ///< [ticks of U, plans of X and Z] in which the acceleration turns
    double longest[hal_n_axes];  ///< [ticks, plans] window, the longest that held meanwhile
    double way_nm[hal_n_axes];   ///< [nm] of X and Z with a turn of the spindle
    double x_low_nm, x_high_nm;  ///< [nm] ends of X's travel
    double commanded_step_nm;   ///< [nm per tick] the command of U, which its feed-forward moves on
    double commanded_change_nm; ///< [nm per tick^2] ...
    double gain_rounding_nm;    ///< [nm] that the feed-forward makes of rounding; 0: there is none
    int64_t stroke_nm;          ///< [nm] of U to either side
    int64_t clearance_nm;       ///< [nm] of X in a fault
    int64_t spindle_mrpm;
    int64_t swing_q32; ///< [turn / 2^32] to either side
} fuzz_limits_t;

static inline double fuzz_more(double a, double b)
{
    return a > b ? a : b;
}

static inline double fuzz_less(double a, double b)
{
    return a < b ? a : b;
}

/// @param tick_hz     [Hz]
/// @param plan_ticks  from plan to plan
fuzz_limits_t fuzz_limits(const cam_params_t *p, uint32_t tick_hz, uint32_t plan_ticks);

/// Widen limits to those that also hold now.
void fuzz_limits_widen(fuzz_limits_t *l, const fuzz_limits_t *now);

/// @return [ticks] within which all axes have left the work, but for the swing and for windows
/// @param rise_nm  [nm] by which U and X may leave further
double fuzz_limits_patience(const fuzz_limits_t *l, int32_t rise_nm);

#endif
