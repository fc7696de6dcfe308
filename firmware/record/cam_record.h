// SPDX-License-Identifier: Apache-2.0
/// cam_record: data passed between the stages of a tick.
///
///     sense -> cam_sense_t -> observe -> cam_angle_t -> play -> cam_want_t -> command -> out
///
/// The guard accepts the last two, or replaces U in them.
///
/// Inputs, results and axis commands form the record of a tick, from which it can be replayed.
/// cam_motion_t holds set-points and increments: the plan writes them, play advances them in every
/// tick. The controller owns all of them (cam_tick.h).
#ifndef CAM_RECORD_H
#define CAM_RECORD_H

#include "cam_fix.h"         // cam_wrap_add_i64
#include "cam_jerk_filter.h" // cam_jerk_filter_t, cam_axis_motion_t
#include "cam_state.h"       // cam_state_t
#include "hal/hal.h"         // hal_encoder_t, hal_n_axes
#include <stdbool.h>         // bool
#include <stdint.h>          // int32_t, int64_t, uint32_t

/// [nm] The controller reads positions within +-2^30 nm, a metre: sums of a few of them fit 32
/// bits. A position beyond that is limited, and the drive counts as not ready.
enum { cam_sense_most_nm = 1 << 30 };

/// All inputs of a tick. The stages after sense see only these and their state, so a recorded tick
/// replays bit for bit.
typedef struct {
    uint32_t clock;                ///< [1 / hal_clock_hz()] at the start of the tick
    hal_encoder_t encoder;         ///< spindle
    int32_t actual_nm[hal_n_axes]; ///< [nm] measured axes; U from its home on
    int32_t swing_q32;             ///< [turn / 2^32] measured swing
    uint32_t inputs;               ///< hal_in_*
    uint32_t request;              ///< serial number << 8 | cam_request_t
} cam_sense_t;

_Static_assert(CAM_FAULT_BIT(estop) == hal_in_estop && CAM_FAULT_BIT(drive) == hal_in_drive_ready &&
                   CAM_FAULT_BIT(bus) == hal_in_bus_lost,
               "an input is its own fault");

/// @return faults reported by the inputs
static inline uint32_t cam_sense_faults(const cam_sense_t *in)
{
    return (in->inputs ^ hal_in_drive_ready) &
           (hal_in_estop | hal_in_drive_ready | hal_in_bus_lost);
}

/// Angle and speed of the spindle in this tick.
typedef struct {
    int64_t pos_q32;       ///< [turn, Q32.32] master position at the instant of sensing
    uint32_t measured_q32; ///< [turn / 2^32] angle of the encoder, without the learned correction
    int32_t speed_q32;     ///< [turn / 2^32 per tick]
    bool is_off_time;      ///< this tick or the last one was visibly off its time
    bool is_synced;        ///< the angle is known
    bool has_stopped;      ///< by this tick the encoder should have advanced, and did not
    uint32_t faults;       ///< late_tick, encoder_jump
} cam_angle_t;

/// @param ticks_q16  [ticks / 2^16] 0 .. 2^31 - 1
/// @return           [turn, Q32.32] master position after some ticks at this speed
static inline int64_t cam_angle_ahead(const cam_angle_t *angle, int32_t ticks_q16)
{
    return cam_wrap_add_i64(angle->pos_q32, ((int64_t)angle->speed_q32 * ticks_q16) >> 16);
}

/// Set-point of the tool's swing. Between two plans its drive continues at constant speed.
typedef struct {
    hal_swing_t set;
    bool is_new;   ///< to be written in the next tick
    bool is_there; ///< at rest at 0, out of the work
} cam_swing_t;

/// U as the guard has accepted it: its set-point, and its command, which leads the set-point in the
/// cut. In state fault both are one.
typedef struct {
    int32_t home_nm;     ///< [nm] U of the controller minus U of the port, found by homing
    int32_t set_q6;      ///< [nm / 64] last set-point
    int32_t set_step_q6; ///< ... its step
    int32_t nm;          ///< [nm] last command
    int32_t step_nm;     ///< [nm per tick] ... its step
    int32_t change_nm;   ///< [nm per tick^2] ... the change of that step
} cam_u_t;

/// Set-points, and their increments per tick until the next plan. The set-points of X, Z and the
/// swing are written as they are.
typedef struct {
    cam_state_t state;
    int32_t spindle_mrpm; ///< [r/min / 1000] set-point, signed
    bool is_playing;      ///< the axes follow the table
    bool is_stopping;     ///< a stop was requested; the next plan schedules the end of the cut.
                          ///< Manual: a disable was requested; the state ends when the axes rest
    bool was_off;         ///< off since the last plan: the angle must be found again
    bool is_clear;        ///< state fault: X has moved off, Z and the swing rest
    bool is_retracted;    ///< state fault: the retract has ended
    bool was_open;        ///< off, and the emergency-stop chain was open since the last plan
    bool is_acknowledged; ///< the button at the machine was pressed (cam_acknowledge.h)
    bool is_by_hand;      ///< manual, and a fault after it: all axes brake where they are
    uint32_t faults;      ///< found by the plan, the force's supervision or a table-fault request;
                          ///< each plan replaces them
    cam_u_t u;            ///< written by the guard; homing shifts it (cam_jog.c)
    cam_axis_motion_t axis[hal_n_axes]; ///< while playing, U's position is in cam_want_t
    int32_t c_q6;            ///< [nm / 64] while playing: learned correction of U's command
    uint32_t dwell_ticks;    ///< [ticks] left of U's rest after enable
    int64_t u_target_q10;    ///< [nm / 1024] target of U while it does not follow the table
    int32_t u_speed_q10;     ///< [nm / 1024 per tick] manual: speed limit of U, 0: it brakes
    int32_t u_push_q6;       ///< [mN / 64] identifying: force that a wave adds to that of U in the
                             ///< next tick; 0: none, or a wave of positions
    int32_t u_press_q6;      ///< [mN / 64] limit of U's force until homed by its stop; 0: none
    int64_t x_left_q10;      ///< [nm / 1024] X in the tick of the fault
    int64_t height_q32;      ///< [slices] U's height on the table
    int32_t height_step_q32; ///< per tick
    int32_t scale_q30, scale_step_q30; ///< [1] amplitude * envelope of U, per tick
    int32_t z_ahead_nm;                ///< [nm] Z of the port minus U's height on the part
    int32_t phase_q32, phase_step_q32; ///< [turn / 2^32], per tick
    int32_t alpha_q40; ///< [turn / 2^40 per tick^2] acceleration of the spindle's set-point
    int32_t alpha_u;   ///< the same, in the unit of U's acceleration
    cam_swing_t swing;
    int32_t change_q10[hal_n_axes]; ///< [nm / 1024 per tick] last change of speed of X and Z
    bool is_filtering; ///< the jerk filters of X and Z ran in the last plan; otherwise they
                       ///< restart where the axes are
    cam_jerk_filter_t filter[hal_n_axes]; ///< motions by time: of U per tick, of X and Z per plan
} cam_motion_t;

/// Set-points of play; in a fault the guard replaces those of U and the spindle.
typedef struct {
    cam_state_t state;
    int32_t spindle_mrpm; ///< [r/min / 1000] set-point, signed
    int32_t z_nm;         ///< [nm] height played
    int32_t u_set_q6;     ///< [nm / 64] U at the tool
    int32_t u_due_q6;     ///< [nm / 64] where U should be measured now
    uint32_t faults;      ///< guard: latched
    uint32_t outputs;     ///< guard: hal_out_*
    bool is_retracted;    ///< guard: tool at rest out of the work
} cam_want_t;

/// Complete inputs and outputs of a tick. Each stage writes its result, the next one reads it.
typedef struct {
    uint32_t tick;                  ///< ticks since start, wraps
    uint32_t config;                ///< generation of the configuration in force
    cam_sense_t in;                 ///< sense
    cam_angle_t angle;              ///< observe
    cam_want_t want;                ///< play, guard
    hal_setpoint_t out[hal_n_axes]; ///< command; U's is replaced where the guard refuses it
    int32_t force_q6;               ///< [mN / 64] force of U that was written; 0: none
} cam_tick_record_t;

/// @return set-point of an axis: a position, with speed and acceleration of its motion
static inline hal_setpoint_t cam_record_setpoint(const cam_axis_motion_t *m, int32_t pos_nm)
{
    return (hal_setpoint_t){.pos_nm = pos_nm, .vel_q10 = m->vel_q10, .acc_q10 = m->acc_q10};
}

/// @return faults found so far in a tick: by inputs, spindle, force, play and the last plan
static inline uint32_t cam_record_faults(const cam_tick_record_t *r, const cam_motion_t *m)
{
    return m->faults | r->angle.faults | cam_sense_faults(&r->in);
}

/// @return whether the set-point of U rests
static inline bool cam_record_is_u_at_rest(const cam_tick_record_t *r)
{
    return r->out[hal_axis_u].vel_q10 == 0 && r->out[hal_axis_u].acc_q10 == 0;
}

#endif
