// SPDX-License-Identifier: Apache-2.0
/// fuzz_judge: what must hold after every tick, whatever came in.
#ifndef FUZZ_JUDGE_H
#define FUZZ_JUDGE_H

#include "cam_param.h"   // cam_params_t
#include "cam_record.h"  // cam_tick_record_t
#include "fuzz_limits.h" // fuzz_limits_t
#include <stdbool.h>     // bool
#include <stdint.h>      // int32_t, int64_t

enum { fuzz_judge_ticks = 64 }; ///< more than from plan to plan

typedef struct {
    uint32_t tick_hz;
    uint32_t plan_ticks;  ///< from plan to plan
    uint32_t version;     ///< of the parameters that the limits are of
    fuzz_limits_t limits; ///< the loosest since the machine was off last; a limit that is narrowed
                          ///< meanwhile binds from the next off on
    int32_t rise_nm;      ///< [nm] by which U and X may leave further in a fault
    cam_state_t state;    ///< of the last tick
    bool is_wild;         ///< by the target: gains and lags are any that are accepted, so that only
                          ///< what the controller supervises is judged, in its wider limits
    bool is_drawn; ///< by the target: a machine of any limits, whose X and Z have the limits of the
                   ///< fault `command` while they are geared to the angle
    uint32_t may_fault;    ///< by the target: faults that it causes; others are the machine's own
    bool has_button;       ///< set by the rig: nothing moves again before a press
    bool is_pressed_right; ///< since the last fault and emergency stop there was one
    bool was_pressed;
    uint32_t n_pressed; ///< [ticks] that the button has been pressed in off, so far
    uint32_t n_runaway; ///< [ticks] since u_runaway was latched
    bool was_enabled;
    bool is_angle_doubtful; ///< by the target: the spindle moved as no spindle can, and X and Z,
                            ///< which are geared to it, have the limits of the fault `command`
                            ///< until the next off
    bool is_taken_out;      ///< ready, behind a stop in the approach: U retracts out of its motion
    bool is_z_led;          ///< Z is measured and not led by this controller
    uint32_t n_alone;       ///< [ticks] since the last sign of life, by the target
    int32_t x_shift_nm;     ///< [nm] by the rig: X's number less that of the port
    uint32_t n_moved;       ///< [ticks] since the enable
    uint32_t n_fault;       ///< [ticks] in state fault
    uint32_t patience;      ///< [ticks] within which the retract has to end
    uint32_t n_off_time;    ///< [ticks] for which a step may be that of a late tick
    uint32_t faults;        ///< latched
    uint32_t request;       ///< the last one
    int32_t commanded_nm[hal_n_axes];    ///< [nm] last commands to the axes, of the port
    int32_t step_nm[hal_n_axes];         ///< ... by how much that differed from the one before
    int32_t change_nm[fuzz_judge_ticks]; ///< ... X: by how much its steps differed, a ring
    int64_t u_change_nm;                 ///< ... U: by how much its steps differed
    uint32_t at;                         ///< place of the newest in it
    int32_t fault_x_nm;                  ///< [nm] X commanded in the tick of the fault
    int64_t swing_on_q32;                ///< [turn / 2^32] of the swing in two plans, as it came
    double outwards_nm;                  ///< [nm] by which it may go on outwards from there
} fuzz_judge_t;

/// Begin in state off.
/// @param rise_nm  [nm] by which the table's U goes below 0
void fuzz_judge_begin(fuzz_judge_t *j, uint32_t tick_hz, int32_t rise_nm);

/// Judge the newest tick; ends the program where an invariant is broken.
/// @param p        parameters as last set
/// @param version  of them: with the same, the limits are the same
/// @param r        record of the tick
void fuzz_judge_tick(fuzz_judge_t *j, const cam_params_t *p, uint32_t version,
                     const cam_tick_record_t *r);

#endif
