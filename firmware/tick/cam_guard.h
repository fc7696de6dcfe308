// SPDX-License-Identifier: Apache-2.0
/// cam_guard: nothing wrong reaches the axes.
///
/// Every tick the guard compares the wanted set-points and the machine's readings with the limits.
/// It latches a fault that is armed in the present state and takes U over: in the same tick U
/// continues at the speed of its last step, because the set-point of that tick is not trusted, and
/// the spindle gets set-point 0; from the next tick on U retracts within its limits, X moves off by
/// the clearance, Z brakes to rest; then the enable drops. When a drive is not ready, the enable
/// drops at once. FAULTS.md states for each fault how soon it is detected, the reaction and the
/// remedy. Context: ISR unless noted.
#ifndef CAM_GUARD_H
#define CAM_GUARD_H

#include "cam_config.h" // cam_guard_config_t
#include "cam_record.h" // cam_tick_record_t, cam_motion_t
#include "cam_state.h"  // cam_fault_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t, int64_t

enum { cam_guard_count_bits = 8 }; ///< faults are counted modulo 256

/// State; zero-initialised is: no faults.
typedef struct {
    uint32_t faults;                      ///< latched
    uint32_t counted;                     ///< of those, what `count` knows
    uint32_t first_faults;                ///< those that entered the fault state last
    uint32_t count[cam_guard_count_bits]; ///< times latched, cam_guard_count()
    uint32_t n_stopped;                   ///< [ticks] without rotation
    int32_t u_set_q6;                     ///< [nm / 64] U written last
    int32_t u_step_q6;                    ///< [nm / 64 per tick] its last step
    int32_t u_acc_q10;                    ///< [nm / 1024 per tick^2] its last acceleration
} cam_guard_t;

/// Judge one tick.
/// @param r     inputs, spindle and what play wants, with all faults that were found before; the
///              guard completes r->want, and replaces it in state fault
/// @param m     set-points of play; in state fault U moves by the guard
/// Constant time.
void cam_guard_step_isr(cam_guard_t *g, const cam_guard_config_t *cfg, cam_tick_record_t *r,
                        cam_motion_t *m);

/// Latch the fault `command`, in the tick in which a command was refused (cam_axis_command.h).
/// @param r, m  as of cam_guard_step_isr(), after it
void cam_guard_refuse_isr(cam_guard_t *g, const cam_guard_config_t *cfg, cam_tick_record_t *r,
                          cam_motion_t *m);

/// The part of the guard that runs once per plan: it judges the speed of the spindle and counts the
/// new faults, which would make the tick of a fault longer.
/// @return faults for the next tick: reverse, spindle_stopped, overspeed
uint32_t cam_guard_plan_isr(cam_guard_t *g, const cam_guard_config_t *cfg,
                            const cam_tick_record_t *r);

/// @return times that a fault was latched, modulo 2^cam_guard_count_bits. Context: slow side.
uint32_t cam_guard_count(const cam_guard_t *g, cam_fault_t fault);

/// @return mask of the faults that are watched in a state. Context: both sides.
uint32_t cam_guard_armed(cam_state_t state);

#endif
