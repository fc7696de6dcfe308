// SPDX-License-Identifier: Apache-2.0
/// cam_config: the configuration, read-only for the interrupt, and its hand-over.
///
/// The slow side (cam_build.h) builds a configuration from parameters and table, with all divisions
/// and range checks, in the half of the bank that is not in use. The interrupt takes it at the
/// start of a tick. No lock: one atomic pointer in each direction. Context of all functions but
/// cam_config_take_isr(): slow side.
#ifndef CAM_CONFIG_H
#define CAM_CONFIG_H

#include "cam_eval.h"   // cam_speed_config_t
#include "cam_fix.h"    // cam_fence_acquire_isr, CAM_ORDER_ACQUIRE
#include "cam_motion.h" // cam_excite_config_t, cam_motion_limits_t, cam_rings_t
#include "cam_record.h" // cam_learned_t
#include "cam_servo.h"  // cam_servo_config_t
#include "cam_table.h"  // cam_table_t
#include "hal/hal.h"    // hal_n_axes
#include <stdatomic.h>  // offered, in_use
#include <stdbool.h>    // bool
#include <stdint.h>     // int16_t, int32_t, int64_t, uint32_t

/// [turn / 2^32 per plan^2] A larger acceleration of the spindle counts as this one.
enum { cam_most_inertia_q32 = 1 << 26 };

/// Configuration of observe (cam_tick_inner.h).
typedef struct {
    const int16_t *dm;                ///< cam_learned_t of the same configuration
    uint32_t sign_mask;               ///< 0, or ~0 when counts fall while cutting
    int32_t counts_per_turn;          ///< 64 .. 2^24
    uint32_t turn_per_count_q32;      ///< [turn / 2^32 per count] whole part of 2^32 / counts
    uint32_t turn_per_count_fraction; ///< ... and 2^32 times the remainder
    uint32_t centre_q32;              ///< [turn / 2^32] offset of the index and half a count
    int32_t kp_q31;                   ///< observer gain of the position per tick
    int32_t ki_q32;                   ///< ... of the speed, below 1/2
    int32_t index_tolerance;          ///< [counts]
    int32_t index_overdue;            ///< [counts] travel without an index edge that is too far
    int32_t jump_window;              ///< [counts] at most a quarter turn
    int32_t max_counts;               ///< [counts / tick] a quarter turn
    int32_t still_counts;             ///< [counts] by which a standing encoder may dither
    int32_t still_q32;                ///< [turn / 2^32] travel without an advance that is too far
    int32_t inertia_q32;              ///< [turn / 2^32 per plan^2] largest acceleration
    int32_t inertia_window_q32;       ///< [turn / 2^32] by which counts may contradict it
    uint32_t tick_clocks;             ///< [1 / clock_hz] period
    uint32_t early_clocks;            ///< [1 / clock_hz] shortest period that counts as on time
    uint32_t on_time_clocks;          ///< [1 / clock_hz] width of the window of periods on time
    uint32_t late_clocks;             ///< [1 / clock_hz] a longer period is a fault
    uint32_t most_clocks;             ///< [1 / clock_hz] longer periods are clamped to this
    uint32_t ticks_per_clock_q27;     ///< [ticks per unit of the time stamp]
    uint32_t stamp_clocks;            ///< [1 / clock_hz] an edge older than this minus a tick is
                                      ///< not used; 0: edges have no time stamps
} cam_spindle_config_t;

/// Fixed-point scaling of the table's U to nm / 64 and nm / 1024.
typedef struct {
    uint32_t speed_shift; ///< speed << this is below 2^30
    int32_t offset;       ///< value at p = 0 in the unit of y
    uint32_t scale_down;  ///< scale_q30 >> this makes the factor of y
    uint32_t y_up, v_up;  ///< shifts of the high words of the products
    uint32_t a_down;      ///< right shift of d2 before the multiplication
    uint32_t a_shift;     ///< right shift of the product
    uint32_t alpha_shift; ///< right shift for the commanded acceleration of the spindle
} cam_u_scale_t;

/// Limits of the return of the swing to 0.
typedef struct {
    int32_t speed_q32; ///< [turn / 2^32 per tick]
    int32_t step_q32;  ///< ... by which it may change from one set-point to the next
    int32_t gain_q32;  ///< [1 / tick] speed over distance, at most a quarter per plan
} cam_swing_limits_t;

/// Configuration of the swing (cam_plan_inner.h).
typedef struct {
    bool is_swung;             ///< the table swings the tool and there is an axis for it
    int32_t ahead_q16;         ///< [ticks] from a plan to the end of its interval, plus the lag
    int32_t lag_q16;           ///< [ticks] of the drive
    int32_t ahead2;            ///< [ticks^2] factor of the spindle's acceleration over that time
    int32_t following_q32;     ///< [turn / 2^32] accepted following error
    int32_t offset_q30;        ///< [turn / 2^30] value of the channel at 0
    int32_t unit_q30;          ///< [turn / 2^30] = value read [2 LSB / 16] * this / 2^32
    cam_swing_limits_t gentle; ///< of the return to 0: a quarter of the machine's limits
    cam_swing_limits_t full;   ///< ... in state fault: all of them
} cam_swing_config_t;

/// Phase of a jog order. The number is part of the CAN protocol.
typedef enum {
    cam_jog_rest,    ///< none: all axes brake and stop
    cam_jog_jog,     ///< the axis moves until the order expires
    cam_jog_step,    ///< ... by a distance
    cam_jog_here,    ///< homing: the present position is the home
    cam_jog_search,  ///< homing: towards the switch or stop
    cam_jog_release, ///< homing: back, off the switch or stop
    cam_jog_index,   ///< homing: on to the index
    cam_jog_n_phases
} cam_jog_phase_t;

/// Result of the last order. The number is part of the CAN protocol.
typedef enum {
    cam_jog_never,      ///< there was none
    cam_jog_runs,       ///< in progress
    cam_jog_done,       ///< the step is made, the home is found
    cam_jog_stopped,    ///< cut short by stop, disable or a fault
    cam_jog_silent,     ///< cut short because the commanding node went silent
    cam_jog_limit,      ///< the axis reached the limit of its travel
    cam_jog_no_switch,  ///< no switch or stop within the travel of the search
    cam_jog_no_release, ///< over that travel the switch stayed active, or U did not leave its stop
    cam_jog_no_index,   ///< no index within that travel
    cam_jog_no_stroke,  ///< with the home found, U would be outside its stroke
    cam_jog_n_ends
} cam_jog_end_t;

/// A jog, step or homing order for one axis. It begins when its serial number is new, and expires
/// at the tick it names; the slow side extends it while the commanding node is alive. Positions are
/// in port coordinates, lengths nm / 1024, speeds nm / 1024 per plan.
typedef struct {
    uint32_t serial;       ///< a new number begins a new order
    uint32_t until;        ///< [tick] at which it expires
    cam_jog_phase_t begin; ///< rest, jog, step, here or search
    hal_axis_t axis;
    int32_t sense;             ///< +1, -1: of a jog, and of the search for the switch
    bool has_index;            ///< homing goes on to the index
    uint16_t still_plans;      ///< [plans] for which U must stand under press_q6 at a stop
    int32_t speed_q10;         ///< of jog, step and search
    int32_t slow_q10;          ///< off the switch, and to the index
    int64_t low_q10, high_q10; ///< travel, that of homing is wider
    int64_t distance_q10;      ///< of a step, signed; homing: travel allowed for each phase
    int32_t home_nm;           ///< [nm] U at its home
    int32_t press_q6;          ///< [mN / 64] limit of U's force to home by a stop; 0: by a switch
} cam_jog_order_t;

/// Configuration of the state manual.
typedef struct {
    cam_motion_limits_t limits[hal_n_axes]; ///< jog speed, gentle acceleration per plan; U per tick
    int64_t u_end_q10;                      ///< [nm / 1024] end of U's stroke
    cam_jog_order_t order;
} cam_jog_config_t;

/// Configuration of the button at the machine (cam_plan.h).
typedef struct {
    bool is_demanded;      ///< false: enable needs no press
    uint32_t settle_plans; ///< [plans] for which a level of the input is stable before it counts
    uint32_t least_plans;  ///< [plans] it is released, and then pressed, at least
    uint32_t most_plans;   ///< [plans] it is pressed at most
    uint32_t good_plans;   ///< [plans] in which enable must come
} cam_acknowledge_config_t;

/// Configuration of play and plan (cam_tick_inner.h, cam_plan.h).
typedef struct {
    const cam_table_t *table; ///< NULL: none, enable is refused
    const int16_t *c;         ///< of cam_learned_t of the same configuration
    const int16_t *d;         ///< ... likewise
    cam_u_scale_t u;
    int32_t lead_q16;                ///< [ticks] dead time of U, below cam_guard_history - 2
    int32_t plan_ticks;              ///< [ticks] from plan to plan, 1 .. 80
    int32_t per_plan_q30;            ///< [1 / ticks] its reciprocal, rounded down
    int32_t xz_lag_q16;              ///< [ticks] lag of X and Z
    int32_t u_plan_q16, xz_plan_q16; ///< [ticks] lead and lag, and to the end of a plan
    int32_t commanded_q16;           ///< [ticks] look-ahead beyond the master position: no axis is
                                     ///< commanded farther
    int32_t ratio_q16;               ///< [ticks] lead of the speed ratio
    int32_t xz_lag2;                 ///< [ticks^2] factor of the spindle's acceleration for X and Z
    int64_t height_max_q32;          ///< [slices] end of the table for U
    uint32_t dwell_ticks;            ///< [ticks] U rests after enable, at least 1
    int32_t phase_q32, phase_step_q32;          ///< [turn / 2^32], per tick
    int32_t amplitude_q30, amplitude_step_q30;  ///< [1], per tick
    int64_t engage_q32, disengage_q32;          ///< [turn] lengths
    uint32_t per_engage_q31, per_disengage_q31; ///< [1/turn] their reciprocals
    int64_t settle_q32;                         ///< [turn] at full amplitude before the feed
    int64_t rehearse_q32;   ///< [turn] at full amplitude before a cut, 0: there is no rehearsal
    int64_t rehearse_x_q10; ///< [nm / 1024] X is this much farther off than at its approach
    int64_t feed_q32;       ///< [turn] from first to last height, ramps included
    int64_t ramp_q32;       ///< [turn] over which the feed rises, and falls
    uint32_t per_ramp_q31;  ///< [1/turn] its reciprocal
    int64_t stop_ramp_q32;  ///< [turn] over which a stop lets the feed fall
    uint32_t per_stop_q31;  ///< [1/turn] its reciprocal
    cam_rings_t rings;      ///< off: the feed is that of a helix
    int32_t feed_nm;        ///< [nm] per turn
    int32_t z_first_nm;     ///< [nm] where the feed starts
    int32_t z_origin_nm;    ///< [nm] Z at height 0 of the part, in port coordinates
    int32_t z_low_nm, z_high_nm; ///< [nm] accepted range of a measured Z, in port coordinates
    int32_t z_margin_nm;         ///< [nm] limit of the following error of a geared Z
    int32_t turning_q32;         ///< [turn / 2^32 per tick] a slower spindle stands
    uint32_t agreeing_q16;       ///< [1] share by which the speeds of steady turns may differ
    uint32_t steady_turns; ///< turns before a cut that agree each with the one before; 0: no wait
    bool is_z_measured;
    int64_t u_retract_q10;  ///< [nm / 1024]
    int32_t x_clearance_nm; ///< [nm]
    int32_t x_high_nm;      ///< [nm] end of X's travel, in port coordinates
    int64_t x_clear_q10;    ///< [nm / 1024] X off the work at every height, likewise
    int64_t x_offset_q10;   ///< [nm / 1024] X where its knots are 0, likewise
    cam_motion_limits_t approach[hal_n_axes]; ///< gentle limits outside the cut; X, Z: per plan
    cam_motion_limits_t leave[hal_n_axes];    ///< full limits of X and Z in state fault, per plan
    int32_t spindle_mrpm;       ///< mean set-point, signed by the table's direction, programmed
    cam_speed_config_t speed;   ///< modulation, of a table with a speed channel
    cam_swing_config_t swing;   ///< of a table that swings the tool
    cam_excite_config_t excite; ///< wave of U in the state identifying
    cam_jog_config_t jog;       ///< order of the state manual
    cam_acknowledge_config_t acknowledge;
    // Changed by the operator in the cut (cam_changes_build()); read by the plan alone
    int32_t feed_rate_q30;     ///< [1] override of the feed; 0: it is held, else at least 1/100
    int32_t per_feed_rate_q24; ///< [1] its reciprocal, 0 where it is held
    int32_t x_trim_q4;         ///< [nm / 16] stock of the pass and the operator's trim
    int32_t x_trim_step_q4;    ///< [nm / 16] largest change per plan
    int32_t spindle_rate_q30;  ///< [1] override of the spindle
    int32_t spindle_step_q30;  ///< [1] largest change per plan
} cam_play_config_t;

/// Configuration of the guard (cam_tick_inner.h).
typedef struct {
    int32_t overspeed_q32;      ///< [turn / 2^32 per tick]
    uint32_t stopped_ticks;     ///< [ticks] in the cut
    uint32_t homing_ticks;      ///< [ticks] for the spindle to turn while homing
    uint32_t due_ticks;         ///< [ticks] whole ones of lead and latency of U's scale
    int32_t due_part_q31;       ///< [ticks / 2^31] their fractional part
    int32_t following_nm;       ///< [nm] accepted following error of U in the cut
    int32_t approach_nm;        ///< [nm] the same where U moves by time, at least as large
    int32_t range_nm;           ///< [nm] half the stroke, for set-point and command of U
    int32_t u_vel_q6, u_acc_q6; ///< [nm / 64 per tick, per tick^2] of the set-point
    int32_t u_acc_off_q6;       ///< [nm / 64 per tick^2] of a tick off its time, whose step differs
    int32_t step_nm;            ///< [nm per tick] speed of the command, feed-forward included
    int32_t change_nm;          ///< [nm per tick^2] its acceleration
    int32_t change_off_nm;      ///< ... in a tick off its time
    cam_motion_limits_t u;      ///< capability of U, within which it retracts
    int64_t u_retract_q10;      ///< [nm / 1024] position of U outside the work
} cam_guard_config_t;

/// Feed-forward of U.
typedef struct {
    int32_t k1_q16;       ///< [ticks] of the velocity
    int32_t k2_q16;       ///< [ticks^2] of the acceleration
    int32_t friction_q14; ///< [nm / 2^14] lead against friction, in the sense of U's motion
    int32_t chip_q32;     ///< [1] of the set-point, against the force of the chip, within +-2^29
    int32_t chip_q6;      ///< [nm / 64] against the mean of that force
} cam_u_gains_t;

/// Feed-forward of U in the cut, and limits of X and Z per plan (cam_tick_inner.h).
typedef struct {
    cam_u_gains_t configured;       ///< without the learned part; no force of the chip
    cam_u_gains_t in_cut;           ///< with it
    int32_t vel_q10[hal_n_axes];    ///< [nm / 1024 per tick] X and Z
    int32_t change_q10[hal_n_axes]; ///< [nm / 1024 per tick] change of speed per plan
    int32_t jump_q10[hal_n_axes];   ///< [nm / 1024] step of position in a plan
} cam_axis_command_config_t;

/// Configuration of the force of U (cam_tick_inner.h).
typedef struct {
    bool is_used; ///< U takes forces
    cam_servo_config_t servo;
    int32_t motion_q24;      ///< [nm per tick^2 per mN / 64] acceleration by a force, times 64
    int32_t pos_q18;         ///< [1] gain of the observer: position
    int32_t vel_q24;         ///< [1 / tick] ... and speed
    int32_t held_q10;        ///< [nm / 1024 per tick^2] by a change of force that friction may hold
    int32_t quantum_q10;     ///< [nm / 1024] step of the scale
    uint32_t still_ticks;    ///< its reading may stand for this long
    int32_t push_speed_q10;  ///< [nm / 1024 per tick] to which a U with a frozen scale is pushed
    int32_t most_excess_q10; ///< [nm / 1024 per tick] the push changes the speed by no more
    uint32_t blind_ticks;    ///< the push takes no longer
    int32_t unseen_nm;       ///< [nm] by which U and its set-point may move while it stands
    int32_t runaway_q6;      ///< [nm / 64] accepted deviation of U from its observer
    int32_t travel_nm;       ///< [nm] U stays within this to either side
    int32_t braking_nm;      ///< [nm per tick^2] twice the acceleration on which braking relies
    uint32_t limited_ticks;  ///< the force may be at its limit for this long
} cam_force_config_t;

/// Everything that a tick reads without changing it.
typedef struct {
    cam_spindle_config_t spindle;
    cam_force_config_t force;
    cam_play_config_t play;
    cam_guard_config_t guard;
    cam_axis_command_config_t command;
    cam_table_t table;   ///< play.table points here
    uint32_t generation; ///< rises with every hand-over
    cam_learned_t learned;
} cam_config_t;

/// Two configurations, one in use.
typedef struct {
    const cam_config_t *_Atomic offered; ///< slow side writes: to be taken from the next tick on
    const cam_config_t *_Atomic in_use;  ///< interrupt writes: that of this tick
    cam_config_t half[2];
} cam_config_bank_t;

/// @return the half that may be written; NULL until the interrupt has taken the previous offer
cam_config_t *cam_config_free_half(cam_config_bank_t *bank);

/// @return the free half with a copy of the newest configuration; NULL likewise
cam_config_t *cam_config_copy(cam_config_bank_t *bank);

/// Set the pointers of a configuration to its own table and learned values, before it is offered.
void cam_config_tie(cam_config_t *config, bool has_table);

/// Add the learned part to the configured gains and limit U's command by them, once before the
/// configuration is offered.
void cam_config_learn(cam_config_t *config);

/// Derive the limits of U's command from those of U and from the feed-forward: speed
/// v + k1 a + k2 j and acceleration a + k1 j + k2 j / tick, all at their largest at once, MATHS.md
/// (213). Call after every change of the gains.
void cam_config_limit_command(cam_config_t *config);

/// The free half is in force from the next tick on.
void cam_config_offer(cam_config_bank_t *bank);

/// @return the configuration of this tick. Context: ISR, constant time.
static inline const cam_config_t *cam_config_take_isr(cam_config_bank_t *bank)
{
    const cam_config_t *offered = atomic_load_explicit(&bank->offered, CAM_ORDER_ACQUIRE);
    cam_fence_acquire_isr();
    cam_fence_release_isr(); // the previous tick has read the other half, which this one releases
    atomic_store_explicit(&bank->in_use, offered, CAM_ORDER_RELEASE);
    return offered;
}

#endif
