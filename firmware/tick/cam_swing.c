// SPDX-License-Identifier: Apache-2.0
#include "cam_swing.h"
#include "cam_angle.h" // cam_angle_of_pos
#include "cam_fix.h"   // cam_mulhi

/// @return [turn / 2^32] where the last line has led; far beyond its end it may wrap
static int32_t led_to(const cam_swing_t *s, uint32_t now)
{
    const uint32_t way_q32 = (uint32_t)s->set.vel_q32 * (now - s->at);
    return (int32_t)((uint32_t)s->set.pos_q32 + way_q32);
}

uint32_t cam_swing_find_isr(cam_swing_t *s, const cam_swing_config_t *cfg, const cam_angle_t *angle,
                            int32_t phase_q32, uint32_t now)
{
    const uint32_t angle_q32 = cam_angle_of_pos(cam_angle_ahead(angle, cfg->ahead_q16));
    s->angle_q32 = angle_q32 - (uint32_t)phase_q32;
    s->from_q32 = led_to(s, now + cam_swing_aim_ticks);
    s->is_there = false;
    return 0;
}

uint32_t cam_swing_place_isr(cam_swing_t *s, const cam_channel_t *ch)
{
    s->place = cam_eval_place(ch, s->angle_q32, s->height);
    return 0;
}

uint32_t cam_swing_knot_isr(cam_swing_t *s, uint32_t end)
{
    s->knot[end] = cam_eval_knot_at(&s->place, end);
    return 0;
}

uint32_t cam_swing_read_isr(cam_swing_t *s, const cam_swing_config_t *cfg)
{
    const cam_segment_t at = {.k0 = s->knot[0], .k1 = s->knot[1], .s_q32 = s->place.s_q32};
    const int32_t y = cam_eval_quintic(at).y; // nobody asks for the derivatives
    const int32_t read_q30 = cam_mulhi_add(cfg->offset_q30, 2 * y, cfg->unit_q30);
    s->read_q32 = (int32_t)((uint32_t)read_q30 * 4u); // an angle: it may wrap
    return 0;
}

static void write_down(cam_swing_t *s, uint32_t now, int32_t pos_q32, int32_t vel_q32)
{
    s->set.pos_q32 = pos_q32;
    s->set.vel_q32 = vel_q32;
    s->at = now;
    s->is_new = true;
}

uint32_t cam_swing_aim_isr(cam_swing_t *s, const cam_swing_config_t *cfg, int32_t scale_q30,
                           uint32_t now)
{
    const int32_t target_q30 = cam_mulhi(s->read_q32, scale_q30);
    const int32_t target_q32 = (int32_t)((uint32_t)target_q30 * 4u);
    const int32_t way_q32 = cam_wrap_sub(target_q32, s->from_q32);
    write_down(s, now, led_to(s, now), cam_mulhi(way_q32, cfg->per_pass_q32));
    return 0;
}

uint32_t cam_swing_look_isr(const cam_swing_t *s, const cam_swing_config_t *cfg, int32_t actual_q32,
                            uint32_t now)
{
    const int32_t behind_q32 = (int32_t)(((int64_t)s->set.vel_q32 * cfg->lag_q16) >> 16);
    const int32_t due_q32 = cam_wrap_sub(led_to(s, now), behind_q32);
    const int32_t off_q32 = cam_wrap_sub(actual_q32, due_q32);
    return cam_is_within(off_q32, cfg->following_q32) ? 0u : CAM_FAULT_BIT(swing);
}

bool cam_swing_rest_isr(cam_swing_t *s, const cam_swing_limits_t *limits, uint32_t now)
{
    if (now % cam_swing_rest_ticks != 0u) {
        return s->is_there;
    }
    const int32_t pos_q32 = led_to(s, now);
    const int32_t most_q32 = limits->speed_q32;
    const int32_t home_q32 = cam_mulhi(pos_q32, -limits->gain_q32);
    const int32_t change_q32 = cam_clamp_i32(home_q32, -most_q32, most_q32) - s->set.vel_q32;
    const int32_t step_q32 = cam_clamp_i32(change_q32, -limits->step_q32, limits->step_q32);
    const int32_t vel_q32 = s->set.vel_q32 + step_q32;
    write_down(s, now, pos_q32, vel_q32);
    s->is_there = vel_q32 == 0 && home_q32 == 0;
    return s->is_there;
}
