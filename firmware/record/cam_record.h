// SPDX-License-Identifier: Apache-2.0
/// cam_record: data passed between the stages of a tick, and from the ticks of a turn to learning.
///
///     sense -> cam_sense_t -> observe -> cam_angle_t -> play -> cam_want_t -> command -> out
///
/// The guard accepts the last two, or replaces U in them.
///
/// Inputs, results and axis commands form the record of a tick.
/// cam_motion_t holds set-points and increments: the plan writes them, play advances them in every
/// tick. The controller owns all of them (cam_tick.h).
///
/// Read the record first; cam_config.h has the configuration by which the stages work, and the last
/// part of this file what they sum over a turn.
#ifndef CAM_RECORD_H
#define CAM_RECORD_H

#include "cam_fix.h"    // cam_wrap_add_i64, cam_angle_of_pos
#include "cam_motion.h" // cam_jerk_filter_t, cam_axis_motion_t
#include "cam_state.h"  // cam_state_t
#include "hal/hal.h"    // hal_encoder_t, hal_n_axes
#include <stdatomic.h>  // cam_turn_bins_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int16_t, int32_t, int64_t, uint32_t

/// [nm] The controller reads positions within +-2^30 nm, a metre: sums of a few of them fit 32
/// bits. A position beyond that is limited, and the drive counts as not ready.
enum { cam_sense_most_nm = 1 << 30 };

/// All inputs of a tick. The stages after sense see only these and their state.
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
    bool is_acknowledged; ///< the button at the machine was pressed (cam_plan.h)
    bool is_by_hand;      ///< manual, and a fault after it: all axes brake where they are
    bool is_u_beyond;     ///< a U that takes forces is beyond its travel, or cannot stop within it
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
    uint32_t u_blind_ticks;  ///< [ticks] remaining of the push outwards of a U with a frozen scale
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

static inline bool cam_record_is_u_at_rest(const cam_tick_record_t *r)
{
    return r->out[hal_axis_u].vel_q10 == 0 && r->out[hal_axis_u].acc_q10 == 0;
}

/// Bins: errors by the angle of a turn, for learning, and the learned tables.
///
/// In every tick the interrupt adds the error of U to one of 128 bins per turn; in a turn of more
/// than 2^14 ticks only in every 2nd, 4th .. 64th one. Two banks of bins alternate from turn to
/// turn: the bank is the lowest bit of the turn number, so a bank holds exactly one turn. While one
/// bank fills, the slow side reads and clears the other one:
///
///     turn      | k - 1      | k          | k + 1      |
///     interrupt | odd bank   | even bank  | odd bank   |
///     slow side |            | reads and clears k - 1, until three quarters of turn k
///
/// From them the slow side computes cam_learned_t, which reaches the interrupt as a part of the
/// configuration (cam_config_copy()): feed-forward gains, a correction c of U's command and
/// the deviation d of the spindle from uniform rotation. Tables and bins are functions of the
/// spindle angle; the slow side rotates them by the operator's phase. All-zero tables correct
/// nothing. Source: MATHS.md (135) .. (138). Context: cam_turn_bins_take() and
/// cam_turn_bins_release(): slow side, one caller; all others: ISR, constant time.

enum {
    cam_turn_bins_log2 = 7,
    cam_turn_bins_n = 1 << cam_turn_bins_log2, ///< per turn
    cam_learned_points = 256,                  ///< knots per turn of the tables
};

/// Learned values, written by the slow side, read by the interrupt. Knot i of a table is at i / 256
/// turn of the master position, knots 256 and 257 equal knots 0 and 1; linear interpolation.
typedef struct {
    int32_t k1_q16;                     ///< [ticks] added to the configured velocity feed-forward
    int32_t k2_q16;                     ///< [ticks^2] added to the acceleration feed-forward
    int32_t friction_q6;                ///< [nm / 64] feed-forward of U's friction
    int32_t chip_q32;                   ///< [1] of U's set-point, against the force of the chip
    int32_t chip_q6;                    ///< [nm / 64] against the mean of that force
    int16_t c[cam_learned_points + 2];  ///< [nm] at full amplitude, added to U's command
    int16_t d[cam_learned_points + 2];  ///< [turn / 2^23] true angle of the spindle minus that of
                                        ///< the observer
    int16_t dm[cam_learned_points + 2]; ///< [turn / 2^23] deviation seen by the encoder: d plus
                                        ///< eccentricity, subtracted before the observer
} cam_learned_t;

/// [turn / 2^32 per tick] Below this speed a turn has too many ticks for the bins even so.
enum { cam_turn_bins_least_q32 = 1 << 12 };

/// One bin: sums over its ticks, which wrap.
typedef struct {
    int32_t error_q6;  ///< [nm / 64] due set-point of U minus measured U: the following
                       ///< error with the opposite sign
    int32_t u_nm;      ///< [nm] due set-point, rounded down
    int32_t angle_q24; ///< [turn / 2^24] measured angle minus begin of the bin; without the learned
                       ///< correction, so it may be outside the bin
    int32_t n;         ///< ticks; once the means are made, the sense in which U moves, 2^20 is 1
} cam_turn_bin_t;

/// Description of a turn whose bank is closed.
typedef struct {
    uint32_t turn;                ///< number of the turn, modulo 2^24
    cam_state_t state;            ///< of all of it, where is_steady
    bool is_steady;               ///< U played the table in all of it in one state, while
                                  ///< the phase was constant
    bool is_level;                ///< amplitude and envelope were constant
    int32_t speed_q32;            ///< [turn / 2^32 per tick] at its last plan
    int32_t scale_q30;            ///< [1] amplitude * envelope at its last plan
    int32_t phase_q32;            ///< [turn / 2^32] the spindle's angle minus the table's
    int32_t z_begin_nm, z_end_nm; ///< [nm] height played in its first and last plan
    uint32_t skip;                ///< ticks left out after each that counts: 0, 1, 3 .. 63
} cam_turn_t;

/// Bins and their turns. Zero-initialised: empty. A bank counts only after the slow side has
/// cleared it, so learning begins with the first call of cam_turn_bins_take().
typedef struct {
    cam_turn_bin_t bin[2 * cam_turn_bins_n]; ///< interrupt adds, slow side clears the idle bank
    cam_turn_t now;                          ///< interrupt only: the current turn
    bool is_clean;                           ///< interrupt only: its bank was clean when it began
    cam_turn_t closed[2];                    ///< interrupt writes: the last turn of each bank
    _Atomic uint32_t closed_turn[2];         ///< interrupt writes: its number + 2^24, 0 if invalid
    _Atomic uint32_t at_q8;      ///< interrupt writes: [turn / 256] position at the last plan
    _Atomic int32_t z_vel_q10;   ///< interrupt writes: [nm / 1024 per tick] speed of Z planned last
    _Atomic uint32_t cleared[2]; ///< slow side writes: turn + 2^24 for which a bank is empty
    uint32_t taken;              ///< slow side only: turn + 2^24 that was taken last
} cam_turn_bins_t;

/// Add a tick to its bin, except where a long turn leaves it out.
static inline void cam_turn_bins_add_isr(cam_turn_bins_t *g, const cam_tick_record_t *r)
{
    if ((r->tick & g->now.skip) != 0u) {
        return;
    }
    const uint32_t low = cam_angle_of_pos(r->angle.pos_q32) >> (32 - cam_turn_bins_log2);
    const uint32_t high = (uint32_t)((uint64_t)r->angle.pos_q32 >> 32);
    const uint32_t i = low | (high & 1u) << cam_turn_bins_log2;
    // The bank bit shifts out of the word, which leaves the begin of the bin.
    const int32_t in_bin_q32 = (int32_t)(r->angle.measured_q32 - (i << (32 - cam_turn_bins_log2)));
    const uint32_t error_q6 =
        (uint32_t)r->want.u_due_q6 - 64u * (uint32_t)r->in.actual_nm[hal_axis_u];
    cam_turn_bin_t *bin = &g->bin[i];
    bin->error_q6 = (int32_t)((uint32_t)bin->error_q6 + error_q6);
    bin->u_nm = cam_wrap_add(bin->u_nm, r->want.u_due_q6 >> 6);
    bin->angle_q24 = cam_wrap_add(bin->angle_q24, in_bin_q32 >> 8);
    bin->n = cam_wrap_add(bin->n, 1);
}

/// Position of an angle between two knots.
typedef struct {
    uint32_t knot;  ///< the first one, 0 .. 255
    uint32_t share; ///< [1 / 256] weights of both knots, that of the first one in the lower half
} cam_learned_place_t;

static inline cam_learned_place_t cam_learned_place(uint32_t theta_q32)
{
    const uint32_t part_q8 = (theta_q32 >> 16) & 0xFFu;
    return (cam_learned_place_t){.knot = theta_q32 >> 24, .share = part_q8 * 0xFFFFu + 256u};
}

/// Read a table between two knots.
/// @param table  cam_learned_points + 1 knots
/// @return       2^8 times the value at the angle, which is rounded down to 2^-16 turn
static inline int32_t cam_learned_at_q8(const int16_t *table, cam_learned_place_t at)
{
    uint32_t knots = 0;
    (void)__builtin_memcpy(&knots, &table[at.knot], sizeof knots); // one load, not a call
    return cam_dot_i16(knots, at.share);
}

/// Derivative of a deviation, half a knot later.
/// @return [2^-23] share by which the spindle is faster than its mean
static inline int32_t cam_learned_faster_q23(const int16_t *table, cam_learned_place_t at)
{
    const cam_learned_place_t next = {.knot = at.knot + 1u, .share = at.share};
    return cam_wrap_sub(cam_learned_at_q8(table, next), cam_learned_at_q8(table, at));
}

/// @return [turn / 2^32] a deviation
static inline uint32_t cam_learned_turn_q32(const int16_t *table, cam_learned_place_t at)
{
    return 2u * (uint32_t)cam_learned_at_q8(table, at);
}

/// Once per plan: on a new turn, close the last one and open the new one.
void cam_turn_bins_plan_isr(cam_turn_bins_t *g, const cam_tick_record_t *r, const cam_motion_t *m);

/// Take the bank of the previous turn, once, if it holds exactly that turn; otherwise clear the
/// idle bank for the next turn. Call it at least three times a turn.
/// @param turn  result
/// @return      128 bins, bin i from i / 128 turn of the master position on, valid until
///              cam_turn_bins_release(); NULL if there is no such turn
const cam_turn_bin_t *cam_turn_bins_take(cam_turn_bins_t *g, cam_turn_t *turn);

/// Clear a bank and give it back.
/// @return false if called later than three quarters into the next turn: the data may have been
///         overwritten while it was read and must be discarded
bool cam_turn_bins_release(cam_turn_bins_t *g);

#endif
