// SPDX-License-Identifier: Apache-2.0
/// cam_guard: detects faults and retracts the tool.
///
/// Every tick the guard compares set-points and readings with the limits. It latches a fault that
/// is armed in the present state and takes over U: in that tick U continues with the speed and
/// acceleration of its last step, because its new set-point is not trusted, and the spindle's
/// set-point becomes 0. From the next tick on U retracts within its limits, X moves off by the
/// clearance, Z brakes; then the enable drops. If a drive is not ready, or U's position loop does
/// not work, the enable drops at once. FAULTS.md lists detection time, reaction and remedy of each
/// fault. Context: ISR unless noted.
#ifndef CAM_GUARD_H
#define CAM_GUARD_H

#include "cam_config.h" // cam_guard_config_t
#include "cam_record.h" // cam_tick_record_t, cam_motion_t
#include "cam_state.h"  // cam_fault_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t, int64_t

enum { cam_guard_count_bits = 8 }; ///< faults are counted modulo 256

/// State; zero-initialised: no faults.
typedef struct {
    uint32_t faults;                      ///< latched
    uint32_t counted;                     ///< faults already in `count`
    uint32_t first_faults;                ///< faults that caused the last entry into state fault
    uint32_t count[cam_guard_count_bits]; ///< times latched, cam_guard_count()
    uint32_t n_stopped;                   ///< [ticks] without rotation
    bool is_going;                        ///< in the work, and the encoder has advanced
    int32_t u_set_q6;                     ///< [nm / 64] last set-point of U
    int32_t u_step_q6;                    ///< [nm / 64 per tick] its last step
    int32_t u_acc_q10;                    ///< [nm / 1024 per tick^2] its last acceleration
} cam_guard_t;

/// Check one tick, in constant time.
/// @param r  inputs, spindle and r->want with all faults found so far; the guard completes r->want,
///           and replaces it in state fault
/// @param m  set-points of play; in state fault the guard moves U
void cam_guard_step_isr(cam_guard_t *g, const cam_guard_config_t *cfg, cam_tick_record_t *r,
                        cam_motion_t *m);

/// @return whether the drives are enabled, as the last tick left the state
bool cam_guard_holds_isr(const cam_guard_t *g, const cam_motion_t *m);

/// Latch the fault `command` in the tick that refused a command (cam_axis_command.h).
/// @param r, m  as left by cam_guard_step_isr()
void cam_guard_refuse_isr(cam_guard_t *g, const cam_guard_config_t *cfg, cam_tick_record_t *r,
                          cam_motion_t *m);

/// The part that runs once per plan: checks the speed of the spindle and counts new faults, which
/// keeps the tick of a fault short.
/// @return faults for the next tick: reverse, spindle_stopped, overspeed
uint32_t cam_guard_plan_isr(cam_guard_t *g, const cam_guard_config_t *cfg,
                            const cam_tick_record_t *r);

/// @return how often a fault was latched, modulo 2^cam_guard_count_bits. Context: slow side.
uint32_t cam_guard_count(const cam_guard_t *g, cam_fault_t fault);

/// @return mask of the faults armed in a state. Context: both sides.
uint32_t cam_guard_armed(cam_state_t state);

#endif
