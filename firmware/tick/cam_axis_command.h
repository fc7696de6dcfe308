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
#include "cam_record.h" // cam_motion_t, cam_u_command_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t, uint32_t

/// State; zero-initialised has told all axes to rest at 0.
typedef struct {
    cam_u_command_t u;           ///< command of U of the last tick
    int32_t fading_q6;           ///< [nm / 64] state fault: the command of U less that of its
                                 ///< set-point
    int32_t vel_q10[hal_n_axes]; ///< [nm / 1024 per tick] X and Z of the last plan
} cam_axis_command_t;

/// Tell U its set-point. In off U may stand anywhere, and is told the end of its stroke where it
/// stands beyond it.
/// @param r       record of the tick, judged by the guard
/// @param m       speed and acceleration of U, and its correction
/// @param is_new  this is the tick of a fault
/// @return        whether it was told; if not, cam_axis_command_nearest_isr() has to be called
/// Constant time.
bool cam_axis_command_isr(cam_axis_command_t *t, const cam_axis_command_config_t *cfg,
                          const cam_tick_record_t *r, const cam_motion_t *m, bool is_new);

/// Tell U the nearest place within its limits to what was refused, or behind a new fault to where
/// its last step leads; what that differs from the command of the retract fades. Where change and
/// place contradict one another the place holds, and where place and step do, since U stands beyond
/// its stroke, the step: U never leaps, and never goes farther out.
/// @param r, m  in state fault
void cam_axis_command_nearest_isr(cam_axis_command_t *t, const cam_axis_command_config_t *cfg,
                                  const cam_tick_record_t *r, const cam_motion_t *m, bool is_new);

/// Let fade what U was told beyond the command of its set-point.
/// @param r, m  in state fault, with a set-point that begins anew
void cam_axis_command_fade_isr(cam_axis_command_t *t, const cam_axis_command_config_t *cfg,
                               const cam_tick_record_t *r, const cam_motion_t *m);

/// Judge what a plan would tell X and Z until the next one: speed, change of speed, and no step of
/// the place. An axis that is faster than its limit may brake. What is not accepted goes on as
/// before the plan.
/// @param m       increments of the plan; what is refused is put back
/// @param before  both axes before the plan
/// @return        fault command or none
uint32_t cam_axis_command_plan_isr(cam_axis_command_t *t, const cam_axis_command_config_t *cfg,
                                   cam_motion_t *m, const cam_axis_motion_t before[hal_n_axes]);

/// U is called by other numbers from the next tick on.
void cam_axis_command_shift_isr(cam_axis_command_t *t, int32_t by_nm);

#endif
