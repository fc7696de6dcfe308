// SPDX-License-Identifier: Apache-2.0
/// cam_swing: swing of the tool about a lobe, linear from plan to plan.
///
///     swing = amplitude * envelope * swing(angle + lag - phase, Z)
///
/// Each plan evaluates the table for the end of its line and gives the drive a set-point with a
/// speed, at which the drive continues until the next one. A line deviates from the table by at
/// most a T^2 / 8, a the acceleration of the swing, T the period of the plan: 0.00043 degrees for
/// 21 600 degrees/s2 and 0.4 ms, MATHS.md (59).
///
/// The swing may rise and fall with the amplitude of U: the tool's tip runs on the roller's circle
/// at any swing, and with U and X in position that circle touches the lobe from outside. A wrong
/// swing leaves material but never cuts too deep. So U and X alone retract the tool, and the swing
/// returns to 0 at its own pace. To first order it is even correct meanwhile: a lobe of lift e H
/// has the pressure angle e gamma.
///
/// Outside the work the swing returns to 0 at a speed in proportion to the distance, within limits.
/// Context: ISR, called by the plan only.
#ifndef CAM_SWING_H
#define CAM_SWING_H

#include "cam_config.h" // cam_play_config_t, cam_swing_limits_t
#include "cam_eval.h"   // cam_height_t
#include "cam_record.h" // cam_swing_t
#include <stdint.h>     // int32_t, uint32_t

/// Plan the next line, starting at the end of the last one.
/// @param theta_q32  [turn / 2^32] angle of the spindle at its end, lag included, minus the phase
/// @param z          slice of the channel then
/// @param scale_q30  amplitude * envelope then
void cam_swing_plan_isr(cam_swing_t *s, const cam_play_config_t *cfg, uint32_t theta_q32,
                        cam_height_t z, int32_t scale_q30);

/// Check that the drive is where the line was one lag ago; the limit allows for a change of speed
/// meanwhile. Call it before planning the next line.
/// @param actual_q32  [turn / 2^32] measured
/// @return            fault swing or none
uint32_t cam_swing_check_isr(const cam_swing_t *s, const cam_play_config_t *cfg,
                             int32_t actual_q32);

/// One plan outside the work: the swing returns to 0 within its limits.
void cam_swing_rest_isr(cam_swing_t *s, const cam_play_config_t *cfg,
                        const cam_swing_limits_t *limits);

/// Without enable the set-point follows the measured swing.
void cam_swing_follow_isr(cam_swing_t *s, int32_t actual_q32);

#endif
