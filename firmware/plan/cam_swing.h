// SPDX-License-Identifier: Apache-2.0
/// cam_swing: the tool's swing about a lobe, one straight line from plan to plan.
///
///     swing = amplitude * envelope * swing(angle + lag - phase, Z)
///
/// Each plan reads the table for the instant at which its line ends and gives the drive a set-point
/// with a speed; the drive goes on at it until the next set-point. A line leaves the table by at
/// most a T^2 / 8, a the acceleration of the swing and T the period of the plan: 21 600 degrees/s2
/// and 0.4 ms are 0.00043 degrees, MATHS.md (59).
///
/// Why it may rise and fall with the amplitude of U: the tool's tip runs on the roller's circle,
/// whatever the swing, and that circle touches the lobe from outside as soon as U and X are where
/// they shall be. A wrong swing leaves material standing; it never cuts too deep. So the tool
/// leaves the work by U and X alone, and the swing returns to 0 at its own pace. To the first order
/// it is right meanwhile, too: a lobe of the lift e H has the pressure angle e gamma.
///
/// Out of the work the swing nears 0 with a speed that falls with the distance, within its limits.
/// Context: ISR, called by the plan only.
#ifndef CAM_SWING_H
#define CAM_SWING_H

#include "cam_config.h" // cam_play_config_t, cam_swing_limits_t
#include "cam_eval.h"   // cam_height_t
#include "cam_record.h" // cam_swing_t
#include <stdint.h>     // int32_t, uint32_t

/// Plan the next line, which starts where the last one ends.
/// @param theta_q32  [turn / 2^32] angle of the spindle at its end, lag included, less the phase
/// @param z          slice of the channel then
/// @param scale_q30  amplitude * envelope then
void cam_swing_plan_isr(cam_swing_t *s, const cam_play_config_t *cfg, uint32_t theta_q32,
                        cam_height_t z, int32_t scale_q30);

/// The drive must be where the line was a lag ago; a change of speed meanwhile is allowed for by
/// the limit. To be called before the next line is made.
/// @param actual_q32  [turn / 2^32] measured
/// @return            fault swing or none
uint32_t cam_swing_check_isr(const cam_swing_t *s, const cam_play_config_t *cfg,
                             int32_t actual_q32);

/// One plan out of the work: the swing nears 0 within its limits.
void cam_swing_rest_isr(cam_swing_t *s, const cam_play_config_t *cfg,
                        const cam_swing_limits_t *limits);

/// Without enable the set-point follows the measured swing.
void cam_swing_follow_isr(cam_swing_t *s, int32_t actual_q32);

#endif
