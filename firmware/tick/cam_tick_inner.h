// SPDX-License-Identifier: Apache-2.0
/// cam_tick_inner: the stages of a tick in their order, private to this room.
///
/// Each stage sees its arguments and its state only (cam_tick.h). Context of all functions: ISR,
/// constant time, unless noted.
#ifndef CAM_TICK_INNER_H
#define CAM_TICK_INNER_H

#include "cam_config.h" // cam_spindle_config_t and those of the other stages
#include "cam_record.h" // cam_tick_record_t, cam_motion_t
#include "cam_state.h"  // cam_state_t
#include "cam_tick.h"   // cam_spindle_t, cam_play_t, cam_force_t, cam_guard_t, cam_trace_t
#include "hal/hal.h"    // hal_encoder_t, hal_n_axes
#include <stdbool.h>    // bool
#include <stddef.h>     // size_t
#include <stdint.h>     // int32_t, uint32_t

/// Begin a tick. A reader that sees anything this tick writes also sees that the tick has begun.
/// @return its record with its number, unchanged for 255 ticks after it
cam_tick_record_t *cam_trace_begin_isr(cam_trace_t *trace);

/// Force: the force of a U that takes forces, and its supervision.
///
/// The position loop (cam_servo.h) runs right after the readings on what the last tick commanded:
/// set-point, speed, acceleration and enable. Its set-point is looked up ahead by lead_ns, which
/// for such a drive is one tick plus servo_force_delay_ns: then it is due when the force acts.
///
/// An observer follows U as a mass with spring and drag under the force that was written. It has
/// both poles at 300 Hz: an unknown force d keeps it d / (mass (2 pi 300 Hz)^2) away, 19 um at 100
/// N and 1.5 kg.
///
///     u_runaway   U deviates from its observer by more than servo_runaway_nm, because its force
///                 acts backwards or something pushes it: the enable drops at once. Or its reading
///                 stands, to the last digit, though U was asked to move and, by its last speed and
///                 what its force has changed since, must have: the scale is frozen, or U is
///                 blocked. Then the force pushes U outwards, by its mass; in manual the enable
///                 drops at once.
///     u_travel    U is beyond its stroke by more than its accepted following error, or too fast to
///                 stop before that with half its force. The enable drops at once: before this U's
///                 set-point has braked within the stroke, so the loop does not work. Or a limit
///                 switch is on, in manual only if U moves towards it: U retracts.
///     u_force     the force was at its limit for servo_limited_ms more than below it, for instance
///                 at the continuous force of a hot motor. U retracts.
///
/// While U is homed by its stop, its force is limited to u_home_force_mn, and u_runaway and u_force
/// are not checked: pressing on a stop looks like both. Source: MATHS.md (238).

/// Calculate the force.
/// @param r      inputs of the tick; r->force_q6 is the result
/// @param is_on  the last tick left the drives enabled; if not, the force is 0, or that which moves
///               a U with a frozen scale
/// @param m      last command of U, speed and acceleration of its set-point; in identifying also
///               the wave's force
void cam_force_step_isr(cam_force_t *f, const cam_force_config_t *cfg, cam_tick_record_t *r,
                        bool is_on, cam_motion_t *m);

/// Supervise U.
/// @param r  with the force of this tick
/// @param m  u_blind_ticks and is_u_beyond are results
/// @return   faults u_travel, u_runaway, u_force or none
uint32_t cam_force_watch_isr(cam_force_t *f, const cam_force_config_t *cfg,
                             const cam_tick_record_t *r, cam_motion_t *m);

/// Observe: from encoder counts and index to master position and speed.
///
/// Converts counts to a binary angle exactly (any counts per turn, no drift), adds half a count to
/// centre the quantisation, and smooths the steps with a second-order tracking observer, which also
/// gives the speed. Speed and position are positive in the direction of cutting.
///
/// A tick off its time by more than a sixteenth of a period is evaluated at its time stamp, so a
/// late tick causes no angle error.
///
/// An encoder that stands still, or only dithers, while the spindle turns shows in has_stopped: in
/// this tick the spindle, at the speed of its last advance, would have gone on by more than
/// `still_q32` since then.
///
/// Errors of the observer, MATHS.md (52), (53), with bandwidth f_o (poles near w_o = 2 pi f_o):
///   constant speed           mean 0; quantisation ripple below half a count
///   constant acceleration    angle lags by (1 - 2 w_o T) acceleration / w_o^2, T one tick,
///                            for the part of it that was not commanded
///   speed ripple at f        (1 - 2 w_o T) f^2 / (f^2 + f_o^2) of the angle ripple is missed

/// Take the reading of a tick, in constant time.
/// @param cfg        forget the angle after changing it
/// @param alpha_q40  [turn / 2^40 per tick^2] commanded acceleration of the spindle since the last
///                   tick, 0 at uniform speed; it causes no lag
void cam_spindle_step_isr(cam_spindle_t *s, const cam_spindle_config_t *cfg, const cam_sense_t *in,
                          int32_t alpha_q40, cam_angle_t *angle);

/// Check the index, once per plan: the first edge makes the angle known, later ones reveal lost
/// counts, and an edge may be overdue.
/// @return fault lost_counts, index_missing or none
uint32_t cam_spindle_check_index_isr(cam_spindle_t *s, const cam_spindle_config_t *cfg,
                                     const hal_encoder_t *encoder);

/// Compare the observer with a spindle whose speed changes no faster than its inertia and a ripple
/// of 1 % twice per turn allow, once per plan. It finds half, doubled or missing counts, which no
/// single tick shows, and an encoder that dithers where it stands.
/// @param is_playing  the tool follows the table; before that any change of the speed is accepted
/// @return fault encoder_jump or none
uint32_t cam_spindle_check_inertia_isr(cam_spindle_t *s, const cam_spindle_config_t *cfg,
                                       bool is_playing);

/// Forget the index and all edges up to now; counts, observer and speed continue.
void cam_spindle_forget_isr(cam_spindle_t *s, const hal_encoder_t *encoder);

/// Play: from master position to set-points of all axes, in every tick.
///
/// While the table plays (rehearsing and engaging once the axes have arrived, cutting, holding,
/// disengaging) every axis is a function of the spindle angle:
///     U = amplitude * envelope * u(angle + speed * lead - phase, Z)
///     Z = first height + feed * turns since feed start   eased in and out (or measured, or along
///         the ring-helix of cam_motion.h)
///     X = x(Z) + trim + (1 - envelope) * clearance       (trim: x_trim_nm and the pass's stock)
///     spindle = mean speed, or mean * (1 + envelope * (ratio(angle, Z) - 1)) where the table
///               modulates it (cam_eval.h)
/// U is evaluated in every tick, at the angle the spindle will have after the drive's dead time.
/// Everything else changes slowly and advances by the increments of the plan (cam_plan.h).
/// Otherwise U moves to a target within its limits, which the plan sets, and the plan moves X and
/// Z; while identifying, a wave is added to U. In off U follows its scale, in fault the guard moves
/// it. A request takes effect in the tick that reads it; the plan schedules the stop of a cut.
/// Source: MATHS.md (54), (55).

/// One tick of the sequence, constant time in each state.
/// @param cfg  with a table, unless the state is off or fault
/// @param r    inputs, request and spindle; r->want is the result, without faults and outputs
/// @param m    set-points, advanced by one tick
void cam_play_step_isr(cam_play_t *p, const cam_play_config_t *cfg, cam_tick_record_t *r,
                       cam_motion_t *m);

/// Command: what the axes are to be commanded.
///
/// In the cut the command of U adds to its set-point the inverse of its drive and the learned
/// correction; a motion by time has no feed-forward:
///
///     command of U = set-point + k1 speed + k2 acceleration + friction + chip + correction
///
/// It is a candidate: the guard accepts it or brakes U. X and Z are commanded to their set-points;
/// speed and change of speed are checked in every plan, which fixes them until the next one. A plan
/// beyond its limits raises the fault `command`, and the axis keeps the motion of the previous
/// plan. In off nothing is refused. Source: MATHS.md (56), (189), (213).

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

/// Guard: accepts the command of U, or brakes it.
///
/// The last stage before the outputs. Every tick the guard compares readings, set-point and command
/// of U with the limits. It accepts the command, or latches a fault that is armed in the present
/// state. From the tick of the fault on it moves U itself: it continues from the last command, with
/// its speed, and retracts U within its limits (after manual it brakes it); the spindle's set-point
/// becomes 0. From the next plan on X moves off by the clearance, and Z brakes; then the enable
/// drops. If a drive is not ready, or U's position loop does not work, the enable drops at once; a
/// U with a frozen scale is pushed outwards first.
/// The command never leaves the stroke: at its end U stops at once, and a U that is already outside
/// moves inward only.
///
///     set-point  speed and acceleration of U                             faults setpoint_*
///     command    its stroke; speed and acceleration with what the
///                feed-forward adds, MATHS.md (213)                       fault command
///
/// If the set-point leaves the stroke, too, the fault is setpoint_range.
/// FAULTS.md lists detection time, reaction and remedy of each fault.

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

/// Hand the complete record to the readers, after a release fence.
void cam_trace_commit_isr(cam_trace_t *trace, cam_tick_record_t *record);

/// Copy words that the interrupt may be writing; such a copy is discarded. Context: slow side.
void cam_trace_copy(void *to, const void *from, size_t n_bytes);

#endif
