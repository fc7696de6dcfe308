// SPDX-License-Identifier: Apache-2.0
/// cam_axis_command: the last word on what the axes are told.
///
/// U is told its set-point, with what its drive needs to bring the tool there and with what was
/// learned of that:
///
///     command of U = set-point + k1 speed + k2 acceleration + correction
///
/// X and Z are told their set-points. Whatever an axis would be told is judged before it is
/// written: place, step and change of the step of U in every tick, speed and change of speed of X
/// and Z in every plan, whose increments are exact for the ticks up to the next one. What is beyond
/// its limits is the fault `command`; it is not written, but the nearest place within the limits.
///
/// In the tick of a fault the command of U goes on with its last step. What that differs from the
/// command of the retract, a correction that was learned or a wave, fades away over the next ticks.
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
    int32_t fading_q6;           ///< [nm / 64] state fault: the command of U less that of its
                                 ///< set-point
    bool is_fault;               ///< the last tick was in state fault
    int32_t vel_q10[hal_n_axes]; ///< [nm / 1024 per tick] X and Z of the last plan
} cam_axis_command_t;

/// Command the axes. In off U may stand anywhere, and is commanded to the end of its stroke where
/// it stands beyond it.
/// @param r       record of the tick, judged by the guard; r->out is the result
/// @param m       set-points, and what was learned of U's command
/// @return        whether the command of U is within its limits; if not, the guard must latch the
///                fault and cam_axis_command_nearest_isr() must be called
/// Constant time.
CAM_MUST_USE bool cam_axis_command_isr(cam_axis_command_t *t, const cam_axis_command_config_t *cfg,
                                       cam_tick_record_t *r, const cam_motion_t *m);

/// Command the axes, and U to the nearest position within its limits to what was refused; in the
/// tick of a new fault, to where its last step leads. The difference from the command of the
/// retract fades. Where acceleration and position contradict each other the position holds; where
/// position and step do, because U stands beyond its stroke, the step does: U never jumps, and
/// never moves farther out.
/// @param r, m  in state fault
void cam_axis_command_nearest_isr(cam_axis_command_t *t, const cam_axis_command_config_t *cfg,
                                  cam_tick_record_t *r, const cam_motion_t *m);

/// Judge what a plan commands X and Z until the next one: speed, change of speed, and no step of
/// the position. An axis that is faster than its limit may brake. A refused axis continues as
/// before the plan.
/// @param m       increments of the plan; those that are refused are put back
/// @param before  both axes before the plan
/// @return        fault command or none
uint32_t cam_axis_command_plan_isr(cam_axis_command_t *t, const cam_axis_command_config_t *cfg,
                                   cam_motion_t *m, const cam_axis_motion_t before[hal_n_axes]);

#endif
