// SPDX-License-Identifier: Apache-2.0
/// cam_axis_command: what the axes are to be commanded.
///
/// In the cut the command of U adds to its set-point the inverse of its drive and the learned
/// correction; a motion by time has no feed-forward:
///
///     command of U = set-point + k1 speed + k2 acceleration + friction + chip + correction
///
/// It is a candidate: the guard accepts it or brakes U (cam_guard.h). X and Z are commanded to
/// their set-points; speed and change of speed are checked in every plan, which fixes them until
/// the next one. A plan beyond its limits raises the fault `command`, and the axis keeps the motion
/// of the previous plan. In off nothing is refused.
/// Source: MATHS.md (56), (189), (213). Context: ISR.
#ifndef CAM_AXIS_COMMAND_H
#define CAM_AXIS_COMMAND_H

#include "cam_config.h" // cam_axis_command_config_t
#include "cam_record.h" // cam_tick_record_t, cam_motion_t
#include <stdint.h>     // int32_t, uint32_t

/// Command the axes, in constant time.
/// @param r  set-point of play; X and Z of r->out are results
/// @return   [nm] command of U for the guard
int32_t cam_axis_command_isr(const cam_axis_command_config_t *cfg, cam_tick_record_t *r,
                             const cam_motion_t *m);

/// Check what a plan commands X and Z until the next one: speed, change of speed, no step of the
/// position. An axis faster than its limit may brake. A refused axis continues as before the plan.
/// @param m       increments of the plan; refused ones are restored
/// @param before  both axes before the plan, with the speeds of the last one
/// @return        fault command or none
uint32_t cam_axis_command_plan_isr(const cam_axis_command_config_t *cfg, cam_motion_t *m,
                                   const cam_axis_motion_t before[hal_n_axes]);

#endif
