// SPDX-License-Identifier: Apache-2.0
#include "cam_plan_inner.h"
#include "cam_fix.h" // cam_mulhi

/// @return [turn / 2^32] position on the line after some ticks; it wraps
static int32_t on_line(const cam_swing_t *s, int32_t ticks)
{
    const uint32_t travel_q32 = (uint32_t)s->set.vel_q32 * (uint32_t)ticks;
    return (int32_t)((uint32_t)s->set.pos_q32 + travel_q32);
}

static void write_set(cam_swing_t *s, int32_t pos_q32, int32_t vel_q32)
{
    s->set.pos_q32 = pos_q32;
    s->set.vel_q32 = vel_q32;
    s->is_new = true;
}

void cam_swing_plan_isr(cam_swing_t *s, const cam_play_config_t *cfg, uint32_t theta_q32,
                        cam_height_t z, int32_t scale_q30)
{
    const int32_t y = cam_eval_quintic(cam_eval_segment(&cfg->table->angle, theta_q32, z)).y;
    const int32_t read_q30 =
        cam_mulhi_add(cfg->swing.offset_q30, cam_sat_add(y, y), cfg->swing.unit_q30);
    const int32_t read_q32 = (int32_t)((uint32_t)read_q30 * 4u); // an angle: it may wrap
    const int32_t target_q32 = (int32_t)((uint32_t)cam_mulhi(read_q32, scale_q30) * 4u);
    // The new line starts at the end of the last one, not at its target: the speed is rounded, and
    // lines must join without a step.
    const int32_t from_q32 = on_line(s, cfg->plan_ticks);
    const int32_t left_q32 = cam_wrap_sub(target_q32, from_q32);
    s->is_there = false;
    write_set(s, from_q32, cam_mul_shift(left_q32, cfg->per_plan_q30, 30));
}

uint32_t cam_swing_check_isr(const cam_swing_t *s, const cam_play_config_t *cfg, int32_t actual_q32)
{
    // The set-point took effect one tick after its plan, so one tick of the line remains.
    const int32_t lag_q32 = (int32_t)(((int64_t)s->set.vel_q32 * cfg->swing.lag_q16) >> 16);
    const int32_t due_q32 = cam_wrap_sub(on_line(s, cfg->plan_ticks - 1), lag_q32);
    const int32_t off_q32 = cam_wrap_sub(actual_q32, due_q32);
    return cam_is_within(off_q32, cfg->swing.following_q32) ? 0u : CAM_FAULT_BIT(swing);
}

void cam_swing_rest_isr(cam_swing_t *s, const cam_play_config_t *cfg,
                        const cam_swing_limits_t *limits)
{
    const int32_t pos_q32 = on_line(s, cfg->plan_ticks);
    const int32_t most_q32 = limits->speed_q32;
    // A speed in proportion to the distance needs no square root, and falls within the limit of the
    // acceleration as the swing nears 0 (cam_build.c chooses the gain so).
    const int32_t home_q32 = cam_mulhi(pos_q32, -limits->gain_q32);
    const int32_t wanted_q32 = cam_clamp_i32(home_q32, -most_q32, most_q32);
    const int32_t change_q32 = cam_wrap_sub(wanted_q32, s->set.vel_q32);
    const int32_t step_q32 = cam_clamp_i32(change_q32, -limits->step_q32, limits->step_q32);
    const int32_t vel_q32 = cam_wrap_add(s->set.vel_q32, step_q32);
    write_set(s, pos_q32, vel_q32);
    s->is_there = vel_q32 == 0 && home_q32 == 0;
}

void cam_swing_follow_isr(cam_swing_t *s, int32_t actual_q32)
{
    s->is_there = false;
    write_set(s, actual_q32, 0);
}
