// SPDX-License-Identifier: Apache-2.0
/// cam_watch: the controller's own state is what it has made of it.
///
/// A bit that flips in memory is no error of the program, and no limit sees it where it stays
/// within them. So what only ticks and plans may change is kept twice, or as a sum (cam_seal.h),
/// and compared: the state, the places of X and Z, home of U and what is about to be written to the
/// axes in every tick, the state of the plan in every plan. What differs is mended from the copy,
/// which one flip has not changed, too, and is the fault `corrupt`. U needs no copy: it is
/// what the tick before told it, within its limits (cam_axis_command.h). Context: ISR.
#ifndef CAM_WATCH_H
#define CAM_WATCH_H

#include "cam_fix.h"          // cam_wrap_sub
#include "cam_plan.h"         // cam_plan_t
#include "cam_record.h"       // cam_motion_t, cam_tick_record_t
#include "cam_axis_command.h" // cam_axis_command_t
#include <stdbool.h>          // bool
#include <stdint.h>           // int32_t, uint32_t

/// State; zero-initialised knows the state off, all places 0 and a plan that was not sealed.
typedef struct {
    int32_t led_nm[hal_n_axes]; ///< [nm] X and Z of the last tick
    int32_t u_home_nm;          ///< [nm] cam_motion_t's
    cam_state_t state;          ///< that tick or plan have left behind
    uint32_t plan_seal;         ///< of cam_plan_t
} cam_watch_t;

/// @return [nm] X or Z is told by this more than its last place and its increment, 0 or 1 by
/// rounding
static inline int32_t cam_watch_strayed_nm(const cam_watch_t *w, const cam_axis_command_t *t,
                                           uint32_t axis, int32_t pos_nm)
{
    return cam_wrap_sub(cam_wrap_sub(pos_nm, w->led_nm[axis]), t->vel_q10[axis] >> 10);
}

/// Between two plans X and Z move by equal increments; whatever else they would be told is not.
/// @return whether they are where that leads them; if not, cam_watch_mend_isr() has to be called.
/// Every tick, behind play.
static inline bool cam_watch_is_on_course_isr(cam_watch_t *w, const cam_axis_command_t *t,
                                              const cam_motion_t *m)
{
    const int32_t x_nm = (int32_t)(m->axis[hal_axis_x].pos_q10 >> 10);
    const int32_t z_nm = (int32_t)(m->axis[hal_axis_z].pos_q10 >> 10);
    const uint32_t x_off = (uint32_t)cam_watch_strayed_nm(w, t, hal_axis_x, x_nm);
    const uint32_t z_off = (uint32_t)cam_watch_strayed_nm(w, t, hal_axis_z, z_nm);
    const bool is_on_course = (x_off | z_off) <= 1u;
    if (is_on_course) {
        w->led_nm[hal_axis_x] = x_nm;
        w->led_nm[hal_axis_z] = z_nm;
    }
    return is_on_course;
}

/// X and Z are not what the last plan and tick make of them. In off they follow the axes, else a
/// bit flipped in a place or in an increment: both are taken from the copies. The copy of a place
/// is what the last record tells.
/// @param last  NULL: none
/// @return      fault corrupt, in off none
uint32_t cam_watch_mend_isr(cam_watch_t *w, cam_axis_command_t *t, cam_motion_t *m,
                            const cam_tick_record_t *last);

/// The state is not the one that was left behind: one of both has flipped. That of the last record
/// tells which one, and the other is mended.
/// @return fault corrupt; off does not watch for it, so nothing is enabled by it
uint32_t cam_watch_mend_state_isr(const cam_watch_t *w, cam_motion_t *m, cam_state_t last);

/// Keep the state that tick or plan leave behind. Behind each of them.
static inline void cam_watch_keep_isr(cam_watch_t *w, const cam_motion_t *m)
{
    w->state = m->state;
}

/// What the axes will be told is compared with what was judged. Before actuate.
/// @return 0 where it is the same; if not, cam_watch_mend_home_isr() has to be called
static inline uint32_t cam_watch_strayed(const cam_watch_t *w, const cam_axis_command_t *t,
                                         const cam_tick_record_t *r)
{
    const int32_t u_off = cam_wrap_add(r->out[hal_axis_u].pos_nm, w->u_home_nm) ^ t->u.nm;
    const int32_t x_off = r->out[hal_axis_x].pos_nm ^ w->led_nm[hal_axis_x];
    const int32_t z_off = r->out[hal_axis_z].pos_nm ^ w->led_nm[hal_axis_z];
    return (uint32_t)(u_off | x_off | z_off);
}

/// Home of U is kept twice, and where both differ one of them has flipped: it is the copy where the
/// other one is what the tick before was told by.
/// @param last  record of that tick
void cam_watch_mend_home_isr(cam_watch_t *w, const cam_axis_command_t *t, cam_motion_t *m,
                             const cam_tick_record_t *last);

/// What only plans change is what the last one has left behind: places of X and Z in full,
/// the state of the plan by its sum. The flag that axes play is kept twice, and only a fault
/// ends it between two plans.
/// @return fault corrupt or none. Before a plan.
uint32_t cam_watch_inspect_isr(cam_watch_t *w, cam_motion_t *m, const cam_plan_t *plan);

/// Keep what a plan leaves behind.
void cam_watch_plan_isr(cam_watch_t *w, const cam_motion_t *m, cam_plan_t *plan);

#endif
