// SPDX-License-Identifier: Apache-2.0
/// cam_shaft: selects the lobe of a shaft, and its lift between two lobes.
///
/// Between two lobes U moves down to the base circle and up again by smooth steps over the height,
/// MATHS.md (87). Pattern and phase change only at amplitude 0, so nothing jumps. At uniform speed
/// the lift falls over the whole transition. With a speed channel it falls over the first half, and
/// the speed ratio moves to 1 over the second, while U rests: the acceleration limits of the table
/// hold for both.
/// Context: ISR, called by the plan only. Constant time.
#ifndef CAM_SHAFT_H
#define CAM_SHAFT_H

#include "cam_lobes.h"  // cam_lobes_slice
#include "cam_record.h" // cam_motion_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t, uint32_t

/// State; zero-initialised: a table without lobes.
typedef struct {
    uint32_t i_lobe;    ///< current lobe
    uint32_t phase_q32; ///< [turn / 2^32] its phase, part of that of cam_motion_t; 0 without lobes
    int64_t z_q8;       ///< [nm / 256] smoothed height of a measured Z
    int64_t speed_q8;   ///< [nm / 256 per plan] its speed
} cam_shaft_t;

/// Shares of lift and speed ratio.
typedef struct {
    int32_t lift_q30;  ///< [1 / 2^30] of the lift
    int32_t ratio_q30; ///< [1 / 2^30] of the ratio's distance from 1
} cam_share_t;

/// @param change_q31  [1 / 2^31] of cam_lobes_change_q31()
/// @param has_speed   the table has a speed channel
cam_share_t cam_shaft_share(int32_t change_q31, bool has_speed);

/// Select the lobe at the first height of a cut. Without lobes the phase is the operator's.
void cam_shaft_begin_isr(cam_shaft_t *s, const cam_table_t *t, int32_t z_nm, cam_motion_t *m);

/// Smooth a measured Z: between two lobes one step of its scale is many steps of U. The tracker has
/// no velocity error; after a jump of the speed by v per plan it lags by at most 5.3 v, below the
/// 20 um margin of a lobe up to 9 mm/s.
/// @return [nm] height for cam_shaft_plan_isr()
int32_t cam_shaft_smooth_isr(cam_shaft_t *s, int32_t z_nm);

/// Select the lobe at U's height. If Z is there early, U still moves to the base circle.
cam_share_t cam_shaft_plan_isr(cam_shaft_t *s, const cam_table_t *t, int32_t z_nm, cam_motion_t *m);

/// @return slice of a channel: pattern of the current lobe, or the slices around the height
static inline cam_height_t cam_shaft_slice(const cam_shaft_t *s, const cam_table_t *t,
                                           const cam_channel_t *ch, int32_t z_nm)
{
    return t->n_lobes > 0u ? cam_lobes_slice(ch->n_slices, t->lobes[s->i_lobe].pattern)
                           : cam_eval_height(ch, z_nm);
}

#endif
