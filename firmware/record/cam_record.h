// SPDX-License-Identifier: Apache-2.0
/// cam_record: what the stages of a tick hand to one another.
///
///     sense -> cam_sense_t -> angle -> cam_angle_t -> play, guard -> cam_want_t -> command -> out
///
/// The first three and what was written to the axes make the record of a tick, from which it can be
/// replayed. cam_motion_t is the record of increments: the plan writes it, play moves it on in
/// every tick. All of them are owned by the controller (cam_tick.h).
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

/// Everything that a tick learns from outside. Steps behind sense see only this and their state, so
/// a recorded tick replays bit for bit.
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

/// @return faults that the inputs report
static inline uint32_t cam_sense_faults(const cam_sense_t *in)
{
    return (in->inputs ^ hal_in_drive_ready) &
           (hal_in_estop | hal_in_drive_ready | hal_in_bus_lost);
}

/// What is known of the spindle after this tick's reading.
typedef struct {
    int64_t pos_q32; ///< [turn, Q32.32] master position at the instant of sensing
    uint32_t
        measured_q32;  ///< [turn / 2^32] angle that the encoder tells, nothing learned taken off
    int32_t speed_q32; ///< [turn / 2^32 per tick]
    bool is_off_time;  ///< this tick or the last one came visibly off its time
    bool is_synced;    ///< the angle is known
    uint32_t faults;   ///< late_tick, encoder_jump
} cam_angle_t;

/// @param ticks_q16  [ticks / 2^16] 0 .. 2^31 - 1
/// @return           [turn, Q32.32] master position after some ticks at this speed
static inline int64_t cam_angle_ahead(const cam_angle_t *angle, int32_t ticks_q16)
{
    return cam_wrap_add_i64(angle->pos_q32, ((int64_t)angle->speed_q32 * ticks_q16) >> 16);
}

/// Set-point of the tool's swing. Between two plans its drive goes on by itself.
typedef struct {
    hal_swing_t set;
    bool is_new;   ///< to be written in the next tick
    bool is_there; ///< at rest at 0, out of the work
} cam_swing_t;

/// The motion that the ticks carry on until the next plan: set-points, and by how much each moves
/// per tick. The set-points of X, Z and the swing are those that are written.
typedef struct {
    cam_state_t state;
    int32_t spindle_mrpm; ///< [r/min / 1000] set-point, signed
    bool is_playing;      ///< in the work and not approaching it: axes follow the table
    bool is_stopping;     ///< a stop was requested; the next plan lays the end of the cut. Manual:
                          ///< a disable was requested; the state ends when the axes rest
    bool was_off;         ///< off since the last plan: the angle must be found anew
    bool is_clear;        ///< state fault: X has moved off, Z and the swing have come to rest
    bool is_retracted;    ///< state fault: the guard's retract has ended
    bool was_open;        ///< off, and the emergency-stop chain was open since the last plan
    bool is_acknowledged; ///< somebody has pressed the button at the machine (cam_acknowledge.h)
    bool is_by_hand;      ///< manual, and a fault behind it: all axes brake where they are
    int32_t u_home_nm;    ///< [nm] U of the controller less U of the port, found by homing
    uint32_t faults;      ///< seen by the plan, for the ticks up to the next one
    cam_axis_motion_t axis[hal_n_axes]; ///< while playing, U's position is in cam_want_t
    int32_t c_q6;                      ///< [nm / 64] while playing: what was learned of U's command
    int64_t u_target_q10;              ///< [nm / 1024] where U goes while it does not play
    int32_t u_speed_q10;               ///< [nm / 1024 per tick] manual: highest of U, 0: it brakes
    int64_t x_left_q10;                ///< [nm / 1024] X in the tick of the fault
    int64_t height_q32;                ///< [slices] U's height on the table
    int32_t height_step_q32;           ///< per tick
    int32_t scale_q30, scale_step_q30; ///< [1] amplitude * envelope of U, per tick
    int32_t lag_q4, lag_step_q4;       ///< [nm / 16] U's height is this far behind Z, per tick
    int32_t phase_q32, phase_step_q32; ///< [turn / 2^32], per tick
    int32_t alpha_q40; ///< [turn / 2^40 per tick^2] acceleration that the set-point demands
    int32_t alpha_u;   ///< the same in the unit of U's
    cam_swing_t swing;
    int32_t change_q10[hal_n_axes]; ///< [nm / 1024 per tick] of X and Z: by which the last plan
                                    ///< changed the speed of the one before
    bool is_filtering; ///< the glides of X and Z are in motion, or rest, since the last
                       ///< plan; else they begin where the axes are
    cam_jerk_filter_t filter[hal_n_axes]; ///< motions by time: of U per tick, of X and Z per plan
} cam_motion_t;

/// What play wants of the machine besides the axes; the guard replaces what it does not accept.
typedef struct {
    cam_state_t state;
    int32_t spindle_mrpm; ///< [r/min / 1000] set-point, signed
    int32_t z_nm;         ///< [nm] height played
    int32_t u_set_q6;     ///< [nm / 64] U at the tool
    int32_t u_due_q6;     ///< [nm / 64] where U should be now
    uint32_t faults;      ///< seen before the guard; then what the guard has latched
    uint32_t outputs;     ///< guard: hal_out_*
    bool is_retracted;    ///< guard: tool at rest out of the work
} cam_want_t;

/// What U was told (cam_axis_command.h).
typedef struct {
    int32_t nm;      ///< [nm] its command, feed-forward included
    int32_t step_nm; ///< [nm per tick] since the tick before
} cam_u_command_t;

/// What one tick did: inputs and outputs complete, so that it can be replayed. Each stage writes
/// its result in here, where the next one reads it.
typedef struct {
    uint32_t tick;                  ///< ticks since start, wraps
    uint32_t config;                ///< generation of the configuration in force
    cam_sense_t in;                 ///< sense
    cam_angle_t angle;              ///< angle
    cam_want_t want;                ///< play, guard
    hal_setpoint_t out[hal_n_axes]; ///< what was written to the axes
} cam_tick_record_t;

#endif
