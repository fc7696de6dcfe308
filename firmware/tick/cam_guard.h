// SPDX-License-Identifier: Apache-2.0
/// cam_guard: accepts the command of U, or brakes it.
///
/// The last stage before the outputs. Every tick the guard compares readings, set-point and command
/// of U with the limits. It accepts the command, or latches a fault that is armed in the present
/// state. From the tick of the fault on it moves U itself: it continues from the last command, with
/// its speed, and retracts U within its limits (after manual it brakes it); the spindle's set-point
/// becomes 0. From the next plan on X moves off by the clearance, and Z brakes; then the enable
/// drops. If a drive is not ready, or U's position loop does not work, the enable drops at once.
/// The command never leaves the stroke: at its end U stops at once, and a U that is already outside
/// moves inward only.
///
///     set-point  speed and acceleration of U                             faults setpoint_*
///     command    its stroke; speed and acceleration with what the
///                feed-forward adds, MATHS.md (213)                       fault command
///
/// If the set-point leaves the stroke, too, the fault is setpoint_range.
/// FAULTS.md lists detection time, reaction and remedy of each fault. Context: ISR unless noted.
#ifndef CAM_GUARD_H
#define CAM_GUARD_H

#include "cam_config.h" // cam_guard_config_t
#include "cam_record.h" // cam_tick_record_t, cam_motion_t
#include "cam_state.h"  // cam_state_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t, uint32_t

/// [ticks] of U kept for the following error; a power of two.
enum { cam_guard_history = 64 };

/// State; zero-initialised: no faults.
typedef struct {
    uint32_t faults;                       ///< latched
    uint32_t first_faults;                 ///< faults that caused the last entry into state fault
    uint32_t n_stopped;                    ///< [ticks] without rotation
    int32_t due_q6;                        ///< [nm / 64] set-point looked up last
    int32_t history_q6[cam_guard_history]; ///< [nm / 64] set-points of U by tick, in port
                                           ///< coordinates modulo 2^32: a new home does not move
                                           ///< them
} cam_guard_t;

/// Check one tick, in constant time.
/// @param r     inputs, spindle and r->want. The guard completes r->want, or replaces it in state
///              fault, and writes U of r->out
/// @param u_nm  [nm] command of U that it may accept, within +-2^25
/// @param m     U as accepted, faults of play and plan; in state fault the motion of U
void cam_guard_step_isr(cam_guard_t *g, const cam_guard_config_t *cfg, cam_tick_record_t *r,
                        int32_t u_nm, cam_motion_t *m);

/// @return whether the drives stay enabled after the last tick
bool cam_guard_holds_isr(const cam_guard_t *g, const cam_motion_t *m);

/// The part that runs once per plan: checks the speed of the spindle.
/// @return faults for the next tick: reverse, spindle_stopped, overspeed
uint32_t cam_guard_plan_isr(cam_guard_t *g, const cam_guard_config_t *cfg,
                            const cam_play_config_t *play, const cam_tick_record_t *r);

/// @return mask of the faults armed in a state. Context: both sides.
uint32_t cam_guard_armed(cam_state_t state);

#endif
