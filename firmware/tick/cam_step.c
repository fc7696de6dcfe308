// SPDX-License-Identifier: Apache-2.0
#include "cam_step.h"
#include "cam_aim.h" // cam_aim_isr
#include "cam_fix.h" // cam_sat_i32

/// @return an axis as it moves from plan to plan; a speed that no limit per plan holds is saturated
static cam_move_t plan_by_plan(const cam_move_t *m, const cam_play_config_t *cfg)
{
    return (cam_move_t){.pos_q10 = m->pos_q10,
                        .vel_q10 = cam_sat_i32((int64_t)m->vel_q10 * cfg->plan_ticks)};
}

bool cam_step_to_isr(cam_move_t *m, const cam_play_config_t *cfg, const cam_move_limits_t *limits,
                     int64_t place_q10)
{
    cam_move_t next = plan_by_plan(m, cfg);
    const bool is_there = cam_move_to_isr(&next, limits, place_q10);
    cam_aim_isr(m, cfg, next.pos_q10);
    return is_there;
}

bool cam_step_brake_isr(cam_move_t *m, const cam_play_config_t *cfg,
                        const cam_move_limits_t *limits)
{
    cam_move_t next = plan_by_plan(m, cfg);
    const bool is_at_rest = cam_move_stop_isr(&next, limits);
    cam_aim_isr(m, cfg, next.pos_q10);
    return is_at_rest;
}
