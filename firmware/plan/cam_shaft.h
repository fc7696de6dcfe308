// SPDX-License-Identifier: Apache-2.0
/// cam_shaft: which lobe of a shaft is played, and what of its lift between two lobes.
///
/// Between two lobes U goes down to the base circle and up again by smooth steps over the height,
/// MATHS.md (87). Pattern and phase change only while the amplitude is 0, so nothing jumps. At a
/// uniform speed the lift falls over the whole change. With a speed channel it falls over the first
/// half, and the ratio goes to 1 over the second: the ratio moves only while U rests, and the
/// accelerations that the table promises hold for both.
/// Context: ISR, called by the plan only. Constant time.
#ifndef CAM_SHAFT_H
#define CAM_SHAFT_H

#include "cam_lobes.h"  // cam_lobes_slice
#include "cam_record.h" // cam_motion_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t, uint32_t

/// State; zero-initialised is a table without lobes.
typedef struct {
    uint32_t i_lobe;    ///< that is played
    uint32_t phase_q32; ///< [turn / 2^32] its phase, which is part of cam_motion_t; 0 without lobes
    int64_t z_q8;       ///< [nm / 256] smoothed height of a measured Z
    int64_t speed_q8;   ///< [nm / 256 per plan] of it
} cam_shaft_t;

/// What is left of lift and speed ratio.
typedef struct {
    int32_t lift_q30;  ///< [1 / 2^30] of the lift
    int32_t ratio_q30; ///< [1 / 2^30] of the ratio's distance from 1
} cam_share_t;

/// @param change_q31  [1 / 2^31] of cam_lobes_change_q31()
/// @param has_speed   the table has a speed channel
cam_share_t cam_shaft_share(int32_t change_q31, bool has_speed);

/// Take up the lobe at the first height of a cut. Without lobes the phase is the operator's alone.
void cam_shaft_begin_isr(cam_shaft_t *s, const cam_table_t *t, int32_t z_nm, cam_motion_t *m);

/// Follow a measured Z smoothly: between two lobes a step of its scale is many of U. The tracker
/// has no error of velocity; after a jump of the speed by v per plan it lags by at most 5.3 v,
/// which is less than the 20 um beside a lobe up to 9 mm/s.
/// @return [nm] height for cam_shaft_plan_isr()
int32_t cam_shaft_smooth_isr(cam_shaft_t *s, int32_t z_nm);

/// Choose the lobe at U's height. A Z that reaches the next lobe too early finds U on its way to
/// the base circle.
cam_share_t cam_shaft_plan_isr(cam_shaft_t *s, const cam_table_t *t, int32_t z_nm, cam_motion_t *m);

/// @return a channel's slice: the pattern of the lobe that is played, or those around the height
static inline cam_height_t cam_shaft_slice(const cam_shaft_t *s, const cam_table_t *t,
                                           const cam_channel_t *ch, int32_t z_nm)
{
    return t->n_lobes > 0u ? cam_lobes_slice(ch->n_slices, t->lobes[s->i_lobe].pattern)
                           : cam_eval_height(ch, z_nm);
}

#endif
