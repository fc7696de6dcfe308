// SPDX-License-Identifier: Apache-2.0
/// cam_tick: the room where everything happens, once per tick.
///
///     sense -> angle -> play -> guard -> actuate -> publish
///
/// and in every n-th tick, before it is published, the plan (cam_plan.h). HAL reads only in sense,
/// HAL writes only in actuate. The tick owns the set-points: play moves them on, the guard judges
/// them, the plan writes their increments, and none of the three knows of another. The state is one
/// struct, so that several controllers fit into a test.
#ifndef CAM_TICK_H
#define CAM_TICK_H

#include "cam_acknowledge.h" // cam_acknowledge_t
#include "cam_config.h"      // cam_config_bank_t
#include "cam_guard.h"       // cam_guard_t
#include "cam_hand.h"        // cam_hand_t
#include "cam_learn.h"       // cam_gather_t
#include "cam_plan.h"        // cam_plan_t
#include "cam_play.h"        // cam_play_t
#include "cam_record.h"      // cam_motion_t, cam_tick_record_t
#include "cam_spindle.h"     // cam_spindle_t
#include "cam_switch.h"      // cam_switches_t
#include "cam_trace.h"       // cam_trace_t
#include <stdatomic.h>       // request, status sequence
#include <stdint.h>          // int32_t, int64_t, uint32_t

/// What the slow side may know of the last tick.
typedef struct {
    uint32_t tick;    ///< ticks since start, wraps
    uint32_t config;  ///< generation of the configuration in force
    uint32_t request; ///< serial number of the last request carried out
    cam_state_t state;
    uint32_t faults;               ///< latched, CAM_FAULT_BIT()
    uint32_t first_fault;          ///< the mask of the tick in which the fault state was entered
    bool is_synced;                ///< angle known
    bool is_retracted;             ///< tool at rest out of the work
    bool is_u_at_rest;             ///< the set-point of U stands
    uint32_t inputs;               ///< hal_in_*
    uint32_t outputs;              ///< hal_out_*
    cam_hand_t hand;               ///< what is moved by hand, and what is homed
    cam_acknowledge_t acknowledge; ///< what is known of the button at the machine
    int64_t pos_q32;               ///< [turn, Q32.32] master position
    int32_t speed_q32;             ///< [turn / 2^32 per tick]
    int32_t z_nm;                  ///< [nm] height played
    int32_t u_set_q6;              ///< [nm / 64] set-point of U at the tool
    int32_t u_actual_nm;           ///< [nm] measured
    int32_t x_actual_nm;           ///< [nm] measured, by the port
    int32_t z_actual_nm;           ///< [nm] measured, by the port
    int32_t following_nm;          ///< [nm] following error: measured minus due
    uint32_t n_late;               ///< late ticks since start
    uint32_t max_period;           ///< [1 / clock_hz] longest distance of two ticks since start
    uint32_t fault_count[cam_n_faults]; ///< times that each fault was latched
} cam_status_t;

/// The controller as the interrupt sees it.
typedef struct {
    // interrupt writes
    cam_spindle_t spindle;
    cam_guard_t guard;   ///< in front, as the motion: offsets of pairs of words stay short
    cam_motion_t motion; ///< set-points and their increments
    cam_play_t play;
    cam_switches_t switches;
    cam_hand_t hand;
    cam_acknowledge_t acknowledge;
    int32_t until_plan;                      ///< [ticks] to the next plan, that tick included
    const cam_tick_record_t *_Atomic newest; ///< NULL before the first tick
    _Atomic uint32_t n_ticks;                ///< ticks that are complete; wraps
    _Atomic uint32_t n_begun;                ///< number of the tick that has begun last
    cam_gather_t gather;                     ///< both sides write, cam_learn.h
    cam_plan_t plan;    ///< behind what every tick uses, whose offsets stay short
    uint32_t plan_seal; ///< of it, since its last plan (cam_seal.h)
    // interrupt reads
    _Atomic uint32_t request; ///< serial number << 8 | cam_request_t
    cam_config_bank_t config; ///< slow side writes the half that is not in use
    // interrupt writes, slow side reads; the largest is the last member, which keeps offsets short
    cam_trace_t trace;
} cam_t;

/// What the interrupt leaves behind a tick, all of the same tick.
typedef struct {
    cam_tick_record_t record;
    cam_spindle_t spindle;
    cam_motion_t motion;
    cam_guard_t guard;
    cam_hand_t hand;
    cam_acknowledge_t acknowledge;
    cam_plan_t plan;
} cam_moment_t;

/// The controller that cam_isr() ticks.
extern cam_t g_cam;

/// Read the newest tick. Where the interrupt runs on another core, or was itself interrupted, it
/// reads until no tick is in progress.
/// @return false before the first tick; *now is that of state off then
/// Context: slow side, which the interrupt may interrupt but not the other way round.
bool cam_tick_moment(const cam_t *c, cam_moment_t *now);

/// @return the status of the newest tick; all fields belong to the same tick
/// Context: slow side.
cam_status_t cam_tick_status(const cam_t *c);

/// One tick. Context: ISR; constant time with and without a plan, loops of constant bounds, no
/// division, no lock.
void cam_tick_isr(cam_t *c);

/// Steps between sense and actuate, and the plan, without the HAL: what a replay calls.
/// @param cfg  configuration of the tick
/// @param r    its number and what it sensed; all the rest is written
/// Context: a replay of a trace.
void cam_tick_steps_isr(cam_t *c, const cam_config_t *cfg, cam_tick_record_t *r);

#endif
