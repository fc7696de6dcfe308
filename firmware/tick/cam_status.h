// SPDX-License-Identifier: Apache-2.0
/// cam_status: status of the newest tick for the slow side.
///
/// The interrupt writes its state in every tick without waiting. A reader copies the state and
/// repeats if a tick was in progress, so all of it belongs to one tick. Context: slow side.
#ifndef CAM_STATUS_H
#define CAM_STATUS_H

#include "cam_tick.h" // cam_t and all that is in it
#include <stdbool.h>  // bool
#include <stdint.h>   // int32_t, int64_t, uint32_t

/// Status of a tick.
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

#endif
