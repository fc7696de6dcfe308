// SPDX-License-Identifier: Apache-2.0
/// cam_swing: the tool's swing of a cam's table, in the tasks of cam_plan.h.
///
///     swing = amplitude * envelope * swing(angle + lag - phase, Z)
///
/// Several passes per round read the table for the instant at which the line to it will end, in
/// steps of a tick each; the set-point then moves there in equal ways, and the drive goes on so
/// until the next one. A line leaves the table by at most a T^2 / 8, a the acceleration of the
/// swing and T the 8 ticks of a pass (10 where the spindle is modulated): 21 600 degrees/s2 and
/// 0.4 ms are 0.00043 degrees, MATHS.md (59). A tick that puts its task off lengthens the line.
///
/// Why it may rise and fall with the amplitude of U: the tool's tip runs on the roller's circle,
/// whatever the swing, and that circle touches the cam from outside as soon as U and X are where
/// they shall be. A wrong swing leaves material standing; it never cuts too deep. So the tool
/// leaves the work by U and X alone, and the swing returns to 0 at its own pace. To the first order
/// it is right on the way, too: a cam of the lift e H has the pressure angle e gamma.
///
/// Out of the work the swing nears 0 with a speed that falls with the distance, within its limits.
/// Context: ISR.
#ifndef CAM_SWING_H
#define CAM_SWING_H

#include "cam_eval.h"    // cam_place_t
#include "cam_spindle.h" // cam_angle_t
#include "hal/hal.h"     // hal_swing_t
#include <stdbool.h>     // bool
#include <stdint.h>      // int32_t, uint32_t

enum { cam_swing_rest_ticks = 8 }; ///< from set-point to set-point out of the work, a power of two
enum { cam_swing_aim_ticks = 5 };  ///< from the begin of a pass to its end

/// Limits of the way to 0.
typedef struct {
    int32_t speed_q32; ///< [turn / 2^32 per tick]
    int32_t step_q32;  ///< ... by which it may change from one set-point to the next
    int32_t gain_q32;  ///< [1 / tick] speed over distance, at most 1/32
} cam_swing_limits_t;

/// Configuration, made by cam_config_build().
typedef struct {
    bool is_swung;        ///< the table swings the tool and there is an axis for it
    int32_t ahead_q16;    ///< [ticks] from the begin of a pass to the end of its line, lag included
    int32_t lag_q16;      ///< [ticks] of the drive
    int32_t per_pass_q32; ///< [1 / ticks] reciprocal of the length of a line
    int32_t following_q32;     ///< [turn / 2^32] accepted following error
    int32_t offset_q30;        ///< [turn / 2^30] value at 0 of the channel
    int32_t unit_q30;          ///< what is read, twice LSB / 16, times this / 2^32 is turn / 2^30
    cam_swing_limits_t gentle; ///< a quarter of the machine's, but in a fault
} cam_swing_config_t;

/// State; zero-initialised is at rest at 0.
typedef struct {
    hal_swing_t set; ///< set-point written last
    uint32_t at;     ///< the tick in which, by the caller's count
    bool is_new;     ///< to be written in this tick
    bool is_there;   ///< at rest at 0, out of the work
    cam_height_t height;
    uint32_t angle_q32; ///< [turn / 2^32] where the table is read
    cam_place_t place;  ///< the same on the channel
    cam_knot_t knot[2]; ///< around it
    int32_t from_q32;   ///< [turn / 2^32] where the line begins, if no tick puts its task off
    int32_t read_q32;   ///< [turn / 2^32] of the table
} cam_swing_t;

/// The angle at the end of the line.
/// @param phase_q32  [turn / 2^32] of the operator
/// @param now        [ticks] count of this tick
CAM_STAGE uint32_t cam_swing_find_isr(cam_swing_t *s, const cam_swing_config_t *cfg,
                                      const cam_angle_t *angle, int32_t phase_q32, uint32_t now);

/// The knots around it.
/// @param ch  kind swing
CAM_STAGE uint32_t cam_swing_place_isr(cam_swing_t *s, const cam_channel_t *ch);

/// @param end  0: the knot before that angle, 1: the one behind it
CAM_STAGE uint32_t cam_swing_knot_isr(cam_swing_t *s, uint32_t end);

/// The quintic between them.
CAM_STAGE uint32_t cam_swing_read_isr(cam_swing_t *s, const cam_swing_config_t *cfg);

/// The next line, from where the last one has led. One that begins late, ticks having put their
/// tasks off, goes on beside the one that was meant.
/// @param scale_q30  amplitude * envelope
CAM_STAGE uint32_t cam_swing_aim_isr(cam_swing_t *s, const cam_swing_config_t *cfg,
                                     int32_t scale_q30, uint32_t now);

/// The drive must be where the line was a lag ago; a change of speed meanwhile is allowed for by
/// the limit.
/// @param actual_q32  [turn / 2^32] measured
/// @return            fault swing or none
CAM_STAGE uint32_t cam_swing_look_isr(const cam_swing_t *s, const cam_swing_config_t *cfg,
                                      int32_t actual_q32, uint32_t now);

/// One tick out of the work, towards 0; a set-point every cam_swing_rest_ticks.
/// @return at rest at 0
CAM_STAGE bool cam_swing_rest_isr(cam_swing_t *s, const cam_swing_limits_t *limits, uint32_t now);

/// Without enable: the set-point is where the tool is.
static inline void cam_swing_follow_isr(cam_swing_t *s, int32_t actual_q32, uint32_t now)
{
    s->set = (hal_swing_t){.pos_q32 = actual_q32};
    s->at = now;
    s->is_new = true;
    s->is_there = false;
}

#endif
