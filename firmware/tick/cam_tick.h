// SPDX-License-Identifier: Apache-2.0
/// cam_tick: the interrupt, once per tick, and what the slow side reads of it.
///
///     sense -> [force of U] -> observe -> play -> command -> guard -> actuate -> [plan] -> publish
///
/// Every n-th tick runs the plan (cam_plan.h). Only sense reads from the HAL, and only actuate
/// writes to it, with one exception: where U takes forces, its position loop runs right after sense
/// on the last tick's command, because each microsecond between the latch of the scale and
/// the force costs stiffness. The tick owns the set-points (cam_motion_t): play advances them,
/// command makes axis commands of them, the guard accepts these or brakes U, and the plan writes
/// their increments. All state is one struct: a test can run several controllers.
///
/// Read the state of each stage, then cam_t with the tick itself, last trace and status, which the
/// slow side reads. cam_tick_inner.h has the manual of each stage.
#ifndef CAM_TICK_H
#define CAM_TICK_H

#include "cam_config.h" // cam_config_bank_t
#include "cam_motion.h" // cam_excite_t
#include "cam_plan.h"   // cam_plan_t, cam_jog_t, cam_acknowledge_t
#include "cam_record.h" // cam_motion_t, cam_tick_record_t, cam_turn_bins_t
#include "cam_servo.h"  // cam_servo_t
#include "cam_state.h"  // cam_state_t
#include <stdatomic.h>  // request, the counters of the trace
#include <stdbool.h>    // bool
#include <stddef.h>     // NULL
#include <stdint.h>     // int32_t, int64_t, uint32_t

/// State of observe: from encoder counts and index to master position and speed. Zero-initialised:
/// not started.
typedef struct {
    bool is_started;
    bool is_synced;
    uint32_t clock;        ///< time stamp of the last tick
    uint32_t counts;       ///< [counts] of the last tick, in the direction of cutting
    uint32_t n_index;      ///< of the last tick
    uint32_t index_counts; ///< [counts] of the last edge, or where the angle was forgotten
    int32_t edge_distance; ///< [counts] between the last two edges, signed; 0: not known
    int32_t index_error;   ///< [counts] sum of deviations since the first edge
    int32_t in_turn;       ///< [counts] 0 .. counts_per_turn - 1 since the index
    bool is_off_time;      ///< the last tick was visibly off its time
    bool is_plan_off_time; ///< ... or one since the last plan
    uint32_t max_period;   ///< [1 / clock_hz] longest period
    uint32_t n_late;       ///< ticks beyond late_clocks
    int32_t behind;        ///< [counts] behind the farthest position, at most 0
    int32_t going_q32;     ///< [turn / 2^32 per tick] speed when the encoder last advanced
    int32_t still_q32;     ///< [turn / 2^32] travel at that speed since then
    uint32_t plan_q32;     ///< [turn / 2^32] angle of the observer at the last plan
    int32_t inert_q32;     ///< [turn / 2^32 per plan] speed that changes as the inertia allows
    int32_t off_q32;       ///< [turn / 2^32] observer minus the travel at that speed
    int32_t n_left_out;    ///< plans with a tick off its time since that speed changed, 0 .. 15
    int64_t pos_q32;       ///< [turn, Q32.32] observer
    int64_t speed_q64;     ///< [turn / 2^64 per tick] observer
} cam_spindle_t;

/// State of play: from master position to set-points. Zero-initialised: no request carried out.
typedef struct {
    uint32_t request;    ///< serial number of the last one carried out
    cam_excite_t excite; ///< in the state identifying
} cam_play_t;

/// State of the force of U. Zero-initialised: off.
typedef struct {
    bool is_on;           ///< the drives were enabled in the last step
    cam_servo_t servo;    ///< position loop
    int64_t pos_q24;      ///< [nm / 2^24] observer, in port coordinates
    int64_t vel_q24;      ///< [nm / 2^24 per tick] observer
    int32_t still_nm;     ///< [nm] last reading
    uint32_t n_still;     ///< [ticks] for which it has stood though U must have moved
    int32_t stood_nm;     ///< [nm] set-point when it last changed
    int32_t reference_q6; ///< [mN / 64] force when U was last not asked to move
    int32_t driven_q10;   ///< [nm / 1024 per tick] speed of U since then, but for friction
    int32_t speed_q10;    ///< [nm / 1024 per tick] least speed of U since then
    int32_t excess_q10;   ///< [nm / 1024 per tick] by which the push is to change the speed of U
    int32_t free_q10;     ///< [nm / 1024] by which U must have moved since then
    uint32_t n_limited;   ///< [ticks] at the limit minus those below it, at least 0
} cam_force_t;

/// [ticks] of U kept for the following error; a power of two.
enum { cam_guard_history = 64 };

/// State of the guard. Zero-initialised: no faults.
typedef struct {
    uint32_t faults;                       ///< latched
    uint32_t first_faults;                 ///< faults that caused the last entry into state fault
    uint32_t n_stopped;                    ///< [ticks] without rotation
    int32_t due_q6;                        ///< [nm / 64] set-point looked up last
    int32_t history_q6[cam_guard_history]; ///< [nm / 64] set-points of U by tick, in port
                                           ///< coordinates modulo 2^32: a new home does not move
                                           ///< them
} cam_guard_t;

/// The trace: the records of the last ticks, written by the interrupt, read by the slow side. A
/// ring without a lock: the record of tick n is ring[n % cam_trace_capacity]. The interrupt never
/// waits for a reader and does not know of it. A reader copies a record, then checks that it was
/// not overwritten meanwhile; it counts the ticks that it has missed.
enum { cam_trace_capacity = 256 }; // a power of two: 12.8 ms at 20 kHz
_Static_assert((cam_trace_capacity & (cam_trace_capacity - 1)) == 0, "index by mask");

/// Zero-initialised: no tick has begun.
typedef struct {
    cam_tick_record_t *_Atomic newest; ///< interrupt writes: of the newest complete tick
    _Atomic uint32_t n_begun;          ///< interrupt writes: ticks that have begun; wraps
    _Atomic uint32_t n_written;        ///< interrupt writes: complete ticks; wraps
    uint32_t n_read;                   ///< slow side only: ticks taken or missed
    uint32_t n_missed;                 ///< slow side only: ... of these the missed ones
    cam_tick_record_t ring[cam_trace_capacity];
} cam_trace_t;

/// The controller as the interrupt sees it.
typedef struct {
    // interrupt writes
    cam_spindle_t spindle;
    cam_play_t play;
    cam_guard_t guard;
    cam_force_t force;   ///< where U takes forces
    cam_motion_t motion; ///< set-points and their increments
    cam_plan_t plan;
    cam_jog_t jog;
    cam_acknowledge_t acknowledge;
    int32_t until_plan; ///< [ticks] to the next plan, that tick included
    // interrupt reads
    _Atomic uint32_t request; ///< serial number << 8 | cam_request_t
    cam_config_bank_t config; ///< slow side writes the half that is not in use
    // both sides
    cam_turn_bins_t bins; ///< errors of U over the turn
    cam_trace_t trace;    ///< interrupt writes, slow side reads
} cam_t;

/// The controller that cam_isr() ticks.
extern cam_t g_cam;

/// One tick. Context: ISR; constant time with and without plan, bounded loops, no division or lock.
void cam_tick_isr(cam_t *c);

/// @return the record of the newest complete tick; before the first one, of a tick in state off.
///         Context: slow side
static inline const cam_tick_record_t *cam_trace_newest(const cam_trace_t *trace)
{
    const cam_tick_record_t *newest = atomic_load_explicit(&trace->newest, memory_order_acquire);
    return newest != NULL ? newest : &trace->ring[0];
}

/// Take the oldest record that was not taken yet and is still in the ring.
/// @return false if all have been taken. Context: slow side, one caller.
bool cam_trace_pop(cam_trace_t *trace, cam_tick_record_t *record);

/// Status of the newest tick for the slow side. The interrupt writes its state in every tick
/// without waiting. A reader copies the state and repeats if a tick was in progress, so all of it
/// belongs to one tick. Context of all that follows: slow side.
typedef struct {
    uint32_t tick;    ///< ticks since start, wraps
    uint32_t config;  ///< generation of the configuration in force
    uint32_t request; ///< serial number of the last request carried out
    cam_state_t state;
    uint32_t faults;               ///< latched, CAM_FAULT_BIT()
    uint32_t first_fault;          ///< faults that caused the entry into state fault
    bool is_synced;                ///< angle known
    bool is_retracted;             ///< tool at rest out of the work
    bool is_u_at_rest;             ///< the set-point of U rests
    uint32_t inputs;               ///< hal_in_*
    uint32_t outputs;              ///< hal_out_*
    cam_jog_t jog;                 ///< jogging and homing
    cam_acknowledge_t acknowledge; ///< the button at the machine
    cam_steady_t steady;           ///< wait for a steady spindle before a cut
    int64_t pos_q32;               ///< [turn, Q32.32] master position
    int32_t speed_q32;             ///< [turn / 2^32 per tick]
    int32_t z_nm;                  ///< [nm] height played
    int32_t u_set_q6;              ///< [nm / 64] set-point of U at the tool
    int32_t u_actual_nm;           ///< [nm] measured
    int32_t x_actual_nm;           ///< [nm] measured, by the port
    int32_t z_actual_nm;           ///< [nm] measured, by the port
    int32_t following_nm;          ///< [nm] following error: measured minus due
    int32_t edge_distance;         ///< [counts] between the last two index edges; 0: not known
    uint32_t n_late;               ///< late ticks since start
    uint32_t max_period;           ///< [1 / clock_hz] longest period since start
} cam_status_t;

/// State of the interrupt after one tick.
typedef struct {
    cam_tick_record_t record;
    cam_spindle_t spindle;
    cam_motion_t motion;
    uint32_t first_faults; ///< of cam_guard_t
    cam_jog_t jog;
    cam_acknowledge_t acknowledge;
    cam_plan_t plan;
} cam_moment_t;

/// Read the newest tick, again and again until no tick was in progress meanwhile (the interrupt may
/// run on another core, but the slow side must never interrupt it).
/// @param now  result; before the first tick 0 in state off
void cam_status_moment(const cam_t *c, cam_moment_t *now);

/// @return number of the newest tick, 0 before the first
static inline uint32_t cam_status_tick(const cam_t *c)
{
    return cam_trace_newest(&c->trace)->tick;
}

/// @return the status of the newest tick; all fields belong to the same tick
cam_status_t cam_status_read(const cam_t *c);

/// @param faults           mask of those to be explained
/// @param counts_per_turn  the parameter
/// @return [counts] found between two index edges where they explain a fault of the encoder: they
///         are others than those set; 0: they do not
uint32_t cam_status_counts_found(const cam_status_t *status, uint32_t faults,
                                 int32_t counts_per_turn);

#endif
