// SPDX-License-Identifier: Apache-2.0
/// cam_guard: nothing wrong reaches the axes.
///
/// Every tick the wanted set-points and the machine's answers are compared with the limits. A fault
/// that is armed in the present state is latched, and the guard takes the axes over: in the same
/// tick U is written where its last speed leads it, not where the fault wants it, the spindle gets
/// set-point 0; from the next tick on U retracts within its limits, X moves off by the clearance, Z
/// brakes to rest; then the enable drops. When a drive is not ready, the enable drops at once.
/// FAULTS.md tells for each fault how soon it is seen, what happens and how to get out. Context:
/// ISR unless noted.
#ifndef CAM_GUARD_H
#define CAM_GUARD_H

#include "cam_move.h"  // cam_move_t
#include "cam_play.h"  // cam_play_t
#include "cam_state.h" // cam_fault_t
#include "cam_trace.h" // cam_tick_record_t
#include <stdbool.h>   // bool
#include <stdint.h>    // int32_t, int64_t

enum { cam_guard_count_bits = 8 }; ///< faults are counted modulo 256

/// Configuration, made by cam_config_build().
typedef struct {
    int32_t overspeed_q32;      ///< [turn / 2^32 per tick]
    int32_t stopped_q32;        ///< [turn / 2^32 per tick]
    uint32_t speed_span_q32;    ///< [turn / 2^32 per tick] from stopped to overspeed
    uint32_t stopped_ticks;     ///< [ticks] in the cut
    uint32_t homing_ticks;      ///< [ticks] for the spindle to turn while homing
    int32_t following_nm;       ///< [nm]
    int32_t u_vel_q6, u_acc_q6; ///< [nm / 64 per tick, per tick^2] of the set-point
    int32_t u_acc_off_q6; ///< [nm / 64 per tick^2] around a tick off its time, whose way is another
    int32_t u_range_q6;   ///< [nm / 64] half the stroke
    cam_move_limits_t limits[hal_n_axes]; ///< for the retract
    int64_t u_retract_q10;                ///< [nm / 1024] place of U out of the work
    int64_t x_clearance_q10;              ///< [nm / 1024] X moves off by this much
    bool is_swung;                        ///< the tool swings
    cam_swing_limits_t swing;             ///< for its way back to 0
} cam_guard_config_t;

/// State; zero-initialised is: no faults.
typedef struct {
    uint32_t faults;                      ///< latched
    uint32_t counted;                     ///< of those, what `count` knows
    uint32_t first_faults;                ///< those that entered the fault state, cam_guard_first()
    uint32_t count[cam_guard_count_bits]; ///< times latched, cam_guard_count()
    bool is_retracted;
    uint32_t n_stopped; ///< [ticks] without rotation
    int64_t x_off_q10;  ///< target of X in the fault state
    int32_t u_set_q6;   ///< [nm / 64] U written last
    int32_t u_step_q6;  ///< [nm / 64 per tick] its last step
} cam_guard_t;

/// Judge one tick.
/// @param r     record of the tick: what was sensed, the spindle and what play wants, each with the
///              faults seen there. `want` is made what is written: state fault from the tick on in
///              which a fault appears, latched faults, outputs
/// @param play  its set-points are made those that may be written; it is told of a fault
/// Constant time.
CAM_STAGE void cam_guard_step_isr(cam_guard_t *g, const cam_guard_config_t *cfg,
                                  cam_tick_record_t *r, cam_play_t *play);

/// @return mask of the faults that entered the fault state last. Context: slow side.
uint32_t cam_guard_first(const cam_guard_t *g);

/// @return times that a fault was latched, modulo 2^cam_guard_count_bits. Context: slow side.
uint32_t cam_guard_count(const cam_guard_t *g, cam_fault_t fault);

/// @return mask of the faults that are watched in a state. Context: both sides.
uint32_t cam_guard_armed(cam_state_t state);

#endif
