// SPDX-License-Identifier: Apache-2.0
/// cam_plan_move: moves an axis from plan to plan: linearly to a target, or within limits per plan.
///
/// A motion within limits runs cam_jerk_filter.h once per plan. It begins with the present speed of
/// the axis and the last change of its speed, within the limits; the ticks interpolate linearly.
/// Context: ISR, constant time, cannot fail.
#ifndef CAM_PLAN_MOVE_H
#define CAM_PLAN_MOVE_H

#include "cam_config.h"       // cam_play_config_t
#include "cam_eval.h"         // cam_eval_profile
#include "cam_fix.h"          // cam_mul_shift
#include "cam_move_profile.h" // cam_motion_limits_t
#include "cam_record.h"       // cam_motion_t
#include <stdbool.h>          // bool
#include <stdint.h>           // int32_t, int64_t

enum { cam_plan_move_most_nm = 2147000000 }; ///< [nm] farthest position of an axis

/// @return increment per tick for a distance until the next plan
static inline int32_t cam_plan_move_share(const cam_play_config_t *cfg, int32_t left)
{
    return cam_mul_shift(left, cfg->per_plan_q30, 30);
}

/// Plan equal increments to a target; the remainder of the division is added at once. The distance
/// saturates at two millimetres per plan: a measured Z that moves faster is followed later. The
/// target is limited so that the position fits the drive's word.
static inline void cam_plan_move_line_isr(cam_axis_motion_t *m, const cam_play_config_t *cfg,
                                          int64_t target_q10)
{
    const int64_t most_q10 = (int64_t)cam_plan_move_most_nm * 1024;
    const int64_t held_q10 = cam_clamp_i64(target_q10, -most_q10, most_q10);
    const int32_t left_q10 = cam_sat_i32(cam_wrap_sub_i64(held_q10, m->pos_q10));
    m->vel_q10 = cam_plan_move_share(cfg, left_q10);
    m->acc_q10 = 0;
    const int64_t rest_q10 = left_q10 - (int64_t)m->vel_q10 * cfg->plan_ticks;
    m->pos_q10 = cam_wrap_add_i64(m->pos_q10, rest_q10);
}

/// @param trim_q4  [nm / 16] stock and trim in force
/// @return [nm / 1024] X over a height with its trim, plus (1 - envelope) of the clearance
static inline int64_t cam_plan_move_profile_q10(const cam_play_config_t *cfg, int32_t z_nm,
                                                int32_t envelope, int32_t trim_q4)
{
    const cam_channel_t *x = &cfg->table->x;
    const int64_t clear_q10 =
        ((int64_t)cfg->x_clearance_nm * ((INT32_C(1) << 30) - envelope)) >> 20;
    return ((int64_t)cam_eval_profile(x, z_nm).y * 1024 >> x->frac_bits) + cfg->x_offset_q10 +
           (int64_t)trim_q4 * 64 + clear_q10;
}

/// Move an axis towards a position, within limits in nm / 1024 per plan and per plan^2.
/// @return true when it rests there
bool cam_plan_move_to_isr(cam_motion_t *m, hal_axis_t axis, const cam_play_config_t *cfg,
                          const cam_motion_limits_t *limits, int64_t position_q10);

/// Brake an axis, likewise.
/// @return true when it rests
bool cam_plan_move_brake_isr(cam_motion_t *m, hal_axis_t axis, const cam_play_config_t *cfg,
                             const cam_motion_limits_t *limits);

#endif
