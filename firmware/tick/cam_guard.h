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

#include "cam_config.h" // cam_guard_config_t
#include "cam_fix.h"    // cam_is_within, cam_wrap_sub
#include "cam_glide.h"  // cam_glide_t, cam_move_t
#include "cam_record.h" // cam_tick_record_t, cam_motion_t, cam_verdict_t
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
    bool is_retracted;
    uint32_t n_stopped;   ///< [ticks] without rotation
    int32_t u_set_q6;     ///< [nm / 64] U written last
    int32_t u_step_q6;    ///< [nm / 64 per tick] its last step
    int32_t u_seal;       ///< u_set_q6 ^ u_step_q6
    cam_move_t u;         ///< set-point in the fault state; before it speed and acceleration of the
                          ///< last tick
    int32_t told_nm;      ///< [nm] command of U, feed-forward included, of the last tick
    int32_t told_step_nm; ///< [nm per tick] its last step
    int32_t told_vel_q10[hal_n_axes]; ///< [nm / 1024 per tick] X and Z of the last plan
    int32_t led_nm[hal_n_axes];       ///< [nm] X and Z of the last tick
    cam_state_t state;                ///< that tick and plan have left behind
    int32_t u_home_nm;                ///< [nm] cam_motion_t's, likewise
    cam_glide_t glide;                ///< of U in the fault state
} cam_guard_t;

/// Judge one tick.
/// @param r  record of the tick: what was sensed, the spindle and what play wants, with all faults
///           that were seen before
/// @param m  set-points that play wants
/// @return   the verdict; while it is in charge, u_set_q6 and u are to be written
/// Constant time.
cam_verdict_t cam_guard_step_isr(cam_guard_t *g, const cam_guard_config_t *cfg,
                                 const cam_tick_record_t *r, const cam_motion_t *m);

/// Enter the fault state. In this tick U continues from its last set-point with the speed and the
/// acceleration of its last step.
/// @param cfg     limits of the retract
/// @param faults  at least one
/// @return        the verdict of the tick
cam_verdict_t cam_guard_enter_isr(cam_guard_t *g, const cam_guard_config_t *cfg, cam_state_t state,
                                  uint32_t faults);

/// Judge the command of U, feed-forward included, in the tick that writes it.
/// @return whether place, step and change of step are within their limits
static inline bool cam_guard_allows_isr(const cam_guard_t *g, const cam_guard_config_t *cfg,
                                        int32_t u_nm, bool is_off_time)
{
    const int32_t step_nm = cam_wrap_sub(u_nm, g->told_nm);
    const int32_t change_nm = cam_wrap_sub(step_nm, g->told_step_nm);
    return cam_is_within(u_nm, cfg->told_range_nm) && cam_is_within(step_nm, cfg->told_step_nm) &&
           (cam_is_within(change_nm, cfg->told_change_nm) ||
            (is_off_time && cam_is_within(change_nm, cfg->told_change_off_nm)));
}

/// @return [nm] the nearest command of U to a wanted one that cam_guard_allows_isr() accepts. Where
/// step and place contradict one another the place holds
int32_t cam_guard_nearest_isr(const cam_guard_t *g, const cam_guard_config_t *cfg, int32_t u_nm);

/// X and Z are not what the last plan and tick make of them. In off they follow the axes, else a
/// bit flipped in a place or in an increment: both are taken from the guard's own copies, which a
/// single flip has not changed, too. @return fault corrupt, in off none. Context: ISR.
uint32_t cam_guard_mend_isr(cam_guard_t *g, cam_motion_t *m);

/// The state is not the one that was left behind: one of both has flipped. That of the last record
/// tells which one, and the other is mended.
/// @return fault corrupt; off does not watch for it, so nothing is enabled by it. Context: ISR.
uint32_t cam_guard_mend_state_isr(const cam_guard_t *g, cam_motion_t *m, cam_state_t last);

/// What only plans change is compared with the guard's copies, in full: places of X and Z, home of
/// U. @return fault corrupt or none. Context: ISR, before a plan.
uint32_t cam_guard_inspect_isr(cam_guard_t *g, cam_motion_t *m);

/// What was written to the axes is compared with what was judged, once it has been written.
/// @return whether it is; if not, the next tick has the fault corrupt. Context: ISR, behind
/// actuate.
static inline bool cam_guard_written_isr(const cam_guard_t *g, const cam_tick_record_t *r)
{
    const int32_t u_off = cam_wrap_add(r->out[hal_axis_u].pos_nm, g->u_home_nm) ^ g->told_nm;
    const int32_t x_off = r->out[hal_axis_x].pos_nm ^ g->led_nm[hal_axis_x];
    const int32_t z_off = r->out[hal_axis_z].pos_nm ^ g->led_nm[hal_axis_z];
    return (u_off | x_off | z_off) == 0;
}

/// Keep what tick or plan leave behind. Context: ISR, behind each of them.
static inline void cam_guard_keep_isr(cam_guard_t *g, const cam_motion_t *m)
{
    g->state = m->state;
}

/// [nm] X or Z is told by this more than its last place and its increment, 0 or 1 by rounding
static inline int32_t cam_guard_strayed_nm(const cam_guard_t *g, uint32_t axis, int32_t pos_nm)
{
    return cam_wrap_sub(cam_wrap_sub(pos_nm, g->led_nm[axis]), g->told_vel_q10[axis] >> 10);
}

/// Between two plans X and Z move by equal increments; whatever else they would be told is not.
/// @return whether they are where that leads them; if not, cam_guard_mend_isr() has to be called.
/// Context: ISR, every tick, behind play.
static inline bool cam_guard_is_on_course_isr(cam_guard_t *g, const cam_motion_t *m)
{
    const int32_t x_nm = (int32_t)(m->axis[hal_axis_x].pos_q10 >> 10);
    const int32_t z_nm = (int32_t)(m->axis[hal_axis_z].pos_q10 >> 10);
    const uint32_t x_off = (uint32_t)cam_guard_strayed_nm(g, hal_axis_x, x_nm);
    const uint32_t z_off = (uint32_t)cam_guard_strayed_nm(g, hal_axis_z, z_nm);
    const bool is_on_course = (x_off | z_off) <= 1u;
    if (is_on_course) {
        g->led_nm[hal_axis_x] = x_nm;
        g->led_nm[hal_axis_z] = z_nm;
    }
    return is_on_course;
}

/// Keep what was told. Context: ISR.
static inline void cam_guard_told_isr(cam_guard_t *g, int32_t u_nm)
{
    g->told_step_nm = cam_wrap_sub(u_nm, g->told_nm);
    g->told_nm = u_nm;
}

/// Judge what a plan would tell X and Z until the next one: speed, change of speed, and no step
/// of the place. The increments are exact for every tick, so that this is judged before the first
/// of these ticks. What is not accepted goes on as before the plan.
/// @param before  both axes before the plan
/// @return        fault command or none
uint32_t cam_guard_increments_isr(cam_guard_t *g, const cam_guard_config_t *cfg, cam_motion_t *m,
                                  const cam_move_t before[hal_n_axes]);

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
