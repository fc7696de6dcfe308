// SPDX-License-Identifier: Apache-2.0
/// cam_axis_command: commands of the axes, and their last limits.
///
/// The command of U adds to its set-point the inverse of its drive and the learned correction:
///
///     command of U = set-point + k1 speed + k2 acceleration + correction
///
/// X and Z are commanded to their set-points. Every command is checked before it is written:
/// position, speed and acceleration of U in every tick; speed and change of speed of X and Z in
/// every plan, which fixes them until the next one. A command beyond its limits raises the fault
/// `command`. U then gets the nearest position within its limits; X and Z keep the motion of the
/// previous plan. In off nothing is refused.
///
/// In the tick of a fault the command of U continues with its last step plus the acceleration of
/// its set-point. Its difference from the command of the retract (a learned correction or a wave)
/// fades over the next ticks.
/// Source: MATHS.md (56), (189), (213). Context: ISR.
#ifndef CAM_AXIS_COMMAND_H
#define CAM_AXIS_COMMAND_H

#include "cam_config.h" // cam_axis_command_config_t
#include "cam_err.h"    // CAM_MUST_USE
#include "cam_record.h" // cam_motion_t, cam_u_command_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t, uint32_t

/// State; zero-initialised all axes are commanded to rest at 0.
typedef struct {
    cam_u_command_t u;           ///< command of U of the last tick
    int32_t fading_q6;           ///< [nm / 64] state fault: command of U minus the command
                                 ///< that its set-point asks for
    bool is_fault;               ///< the last tick was in state fault
    int32_t vel_q10[hal_n_axes]; ///< [nm / 1024 per tick] speeds of X and Z in the last plan
} cam_axis_command_t;

/// Command the axes, in constant time. In off U may stand beyond its stroke; its command then is
/// the end of the stroke.
/// @param r  record of the tick, checked by the guard; r->out is the result
/// @return   whether the command of U is within its limits; if not, the guard must latch the fault,
///           then cam_axis_command_nearest_isr() must be called
CAM_MUST_USE bool cam_axis_command_isr(cam_axis_command_t *t, const cam_axis_command_config_t *cfg,
                                       cam_tick_record_t *r, const cam_motion_t *m);

/// Command the axes after a refusal: U moves to the position within its limits that is nearest to
/// the refused one, or in the first tick of a fault to a repetition of its last step. The
/// difference from the command of the retract fades. If the limits contradict one another, speed
/// takes precedence over the stroke, and the stroke over acceleration: U never jumps, and beyond
/// its stroke it never moves farther out.
/// @param r, m  in state fault
void cam_axis_command_nearest_isr(cam_axis_command_t *t, const cam_axis_command_config_t *cfg,
                                  cam_tick_record_t *r, const cam_motion_t *m);

/// Check what a plan commands X and Z until the next one: speed, change of speed, no step of the
/// position. An axis faster than its limit may brake. A refused axis continues as before the plan.
/// @param m       increments of the plan; refused ones are restored
/// @param before  both axes before the plan
/// @return        fault command or none
uint32_t cam_axis_command_plan_isr(cam_axis_command_t *t, const cam_axis_command_config_t *cfg,
                                   cam_motion_t *m, const cam_axis_motion_t before[hal_n_axes]);

#endif
