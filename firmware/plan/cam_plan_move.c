// SPDX-License-Identifier: Apache-2.0
#include "cam_plan_inner.h"

/// Continue the filtered motion, or begin a new one if something else has moved the axis meanwhile.
/// @return the axis in units per plan, speed saturated
static cam_axis_motion_t plan_by_plan(cam_motion_t *m, hal_axis_t axis,
                                      const cam_play_config_t *cfg,
                                      const cam_motion_limits_t *limits)
{
    cam_jerk_filter_t *filter = &m->filter[axis];
    const cam_axis_motion_t *now = &m->axis[axis];
    const int64_t ticks = cfg->plan_ticks;
    // A jump of the spindle accelerates geared axes beyond their limits; a motion that continued
    // so would carry X into the work before it retracts.
    const int64_t most_q10 = limits->acceleration_q10;
    const int64_t change_q10 = m->change_q10[axis] * ticks;
    const int64_t acc_q10 = cam_clamp_i64(change_q10, -most_q10, most_q10);
    const cam_axis_motion_t next = {.pos_q10 = now->pos_q10,
                                    .vel_q10 = cam_sat_i32(now->vel_q10 * ticks),
                                    .acc_q10 = (int32_t)acc_q10};
    if (!m->is_filtering || now->pos_q10 != filter->sum_pos_q10 >> filter->log2_window) {
        cam_jerk_filter_begin_isr(filter, &next, limits->log2_window);
    }
    return next;
}

bool cam_plan_move_to_isr(cam_motion_t *m, hal_axis_t axis, const cam_play_config_t *cfg,
                          const cam_motion_limits_t *limits, int64_t position_q10)
{
    cam_axis_motion_t next = plan_by_plan(m, axis, cfg, limits);
    cam_jerk_filter_t *filter = &m->filter[axis];
    const bool is_there = cam_jerk_filter_to_isr(filter, &next, limits, position_q10);
    cam_plan_move_line_isr(&m->axis[axis], cfg, next.pos_q10);
    return is_there;
}

bool cam_plan_move_brake_isr(cam_motion_t *m, hal_axis_t axis, const cam_play_config_t *cfg,
                             const cam_motion_limits_t *limits)
{
    cam_axis_motion_t next = plan_by_plan(m, axis, cfg, limits);
    const bool is_at_rest = cam_jerk_filter_stop_isr(&m->filter[axis], &next, limits);
    cam_plan_move_line_isr(&m->axis[axis], cfg, next.pos_q10);
    return is_at_rest;
}
