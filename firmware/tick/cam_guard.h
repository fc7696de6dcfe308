// SPDX-License-Identifier: Apache-2.0
/// cam_guard: nothing wrong reaches the axes.
///
/// Every tick the wanted set-points and the machine's answers are compared with the limits. The
/// guard changes none of them: it returns a verdict, and while it is in charge it has set-points of
/// its own (cam_guard_t.u), which the tick writes in the place of play's. A fault that is armed
/// in the present state is latched, and the guard takes the axes over: in the same tick U
/// continues at the speed of its last step, because the set-point of that tick is not trusted, and
/// the spindle gets set-point 0; from the next tick on U retracts within its limits, X moves off by
/// the clearance, Z brakes to rest; then the enable drops. When a drive is not ready, the enable
/// drops at once. FAULTS.md states for each fault how soon it is detected, the reaction and the
/// remedy. Context: ISR unless noted.
#ifndef CAM_GUARD_H
#define CAM_GUARD_H

#include "cam_config.h"      // cam_guard_config_t
#include "cam_jerk_filter.h" // cam_jerk_filter_t, cam_axis_motion_t
#include "cam_record.h"      // cam_tick_record_t, cam_motion_t, cam_verdict_t
#include "cam_state.h"       // cam_fault_t
#include <stdbool.h>         // bool
#include <stdint.h>          // int32_t, int64_t

enum { cam_guard_count_bits = 8 }; ///< faults are counted modulo 256

/// State; zero-initialised is: no faults.
typedef struct {
    uint32_t faults;                      ///< latched
    uint32_t counted;                     ///< of those, what `count` knows
    uint32_t first_faults;                ///< those that entered the fault state last
    uint32_t count[cam_guard_count_bits]; ///< times latched, cam_guard_count()
    bool is_retracted;
    uint32_t n_stopped;  ///< [ticks] without rotation
    int32_t u_set_q6;    ///< [nm / 64] U written last
    int32_t u_step_q6;   ///< [nm / 64 per tick] its last step
    int32_t u_seal;      ///< u_set_q6 ^ u_step_q6
    cam_axis_motion_t u; ///< set-point in the fault state; before it speed and acceleration of the
                         ///< last tick
    cam_jerk_filter_t filter; ///< of U in the fault state
} cam_guard_t;

/// Judge one tick.
/// @param r     record of the tick: what was sensed, the spindle and what play wants, with all
///              faults that were seen before
/// @param m     set-points that play wants
/// @param told  command of U of the last tick
/// @return      the verdict; while it is in charge, u_set_q6 and u are to be written
/// Constant time.
cam_verdict_t cam_guard_step_isr(cam_guard_t *g, const cam_guard_config_t *cfg,
                                 const cam_tick_record_t *r, const cam_motion_t *m,
                                 const cam_u_command_t *told);

/// Enter the fault state. In this tick U continues from its last set-point with the speed and the
/// acceleration of its last step.
/// @param cfg     limits of the retract
/// @param faults  at least one
/// @param told    command of U of the last tick, for a set-point of which a bit has flipped
/// @return        the verdict of the tick
cam_verdict_t cam_guard_enter_isr(cam_guard_t *g, const cam_guard_config_t *cfg, cam_state_t state,
                                  uint32_t faults, const cam_u_command_t *told);

/// In the fault state: the retract begins again where U was told to be, with the speed of that.
/// @param cfg   limits of the retract
/// @param told  command of U of this tick
void cam_guard_begin_isr(cam_guard_t *g, const cam_guard_config_t *cfg,
                         const cam_u_command_t *told);

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
