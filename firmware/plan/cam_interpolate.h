// SPDX-License-Identifier: Apache-2.0
/// cam_interpolate: linear interpolation between plans, and X over a height.
///
/// Inline, constant time, cannot fail. Context: ISR.
#ifndef CAM_INTERPOLATE_H
#define CAM_INTERPOLATE_H

#include "cam_config.h"       // cam_play_config_t
#include "cam_eval.h"         // cam_eval_profile
#include "cam_fix.h"          // cam_mul_shift
#include "cam_move_profile.h" // cam_axis_motion_t
#include <stdint.h>           // int32_t, int64_t

enum { cam_interpolate_most_nm = 2147000000 }; ///< [nm] farthest position of an axis

/// @return increment per tick for a distance until the next plan
static inline int32_t cam_interpolate_share(const cam_play_config_t *cfg, int32_t left)
{
    return cam_mul_shift(left, cfg->per_plan_q30, 30);
}

/// Plan equal increments to a target; the remainder of the division is added at once. The distance
/// saturates at two millimetres per plan: a measured Z that moves faster is followed later. The
/// target is limited so that the position fits the drive's word.
static inline void cam_interpolate_isr(cam_axis_motion_t *m, const cam_play_config_t *cfg,
                                       int64_t target_q10)
{
    const int64_t most_q10 = (int64_t)cam_interpolate_most_nm * 1024;
    const int64_t held_q10 = cam_clamp_i64(target_q10, -most_q10, most_q10);
    const int32_t left_q10 = cam_sat_i32(cam_wrap_sub_i64(held_q10, m->pos_q10));
    m->vel_q10 = cam_interpolate_share(cfg, left_q10);
    m->acc_q10 = 0;
    const int64_t rest_q10 = left_q10 - (int64_t)m->vel_q10 * cfg->plan_ticks;
    m->pos_q10 = cam_wrap_add_i64(m->pos_q10, rest_q10);
}

/// @param trim_q4  [nm / 16] stock and trim in force
/// @return [nm / 1024] X over a height with its trim, plus (1 - envelope) of the clearance
static inline int64_t cam_interpolate_profile_q10(const cam_play_config_t *cfg, int32_t z_nm,
                                                  int32_t envelope, int32_t trim_q4)
{
    const cam_channel_t *x = &cfg->table->x;
    const int64_t clear_q10 =
        ((int64_t)cfg->x_clearance_nm * ((INT32_C(1) << 30) - envelope)) >> 20;
    return ((int64_t)cam_eval_profile(x, z_nm).y * 1024 >> x->frac_bits) + cfg->x_offset_q10 +
           (int64_t)trim_q4 * 64 + clear_q10;
}

#endif
