// SPDX-License-Identifier: Apache-2.0
#include "cam_modulate.h"
#include "cam_angle.h" // cam_angle_of_pos
#include "cam_eval.h"  // cam_eval_height
#include "cam_fix.h"   // cam_sat_i32
#include "cam_plan.h"  // cam_plan_keep_height

/// The speed ratio is read for the middle of the ticks that will use it, seen from this one.
uint32_t cam_modulate_find_slices_isr(cam_play_t *p, const cam_play_config_t *cfg,
                                      const cam_angle_t *angle)
{
    const uint32_t angle_q32 = cam_angle_of_pos(cam_angle_ahead(angle, cfg->ratio_q16));
    p->plan.ratio_angle_q32 = angle_q32 - (uint32_t)p->phase_q32;
    cam_plan_keep_height(&p->plan.ratio_height, cam_eval_height(&cfg->table->speed, p->plan.z_nm));
    return 0;
}

uint32_t cam_modulate_find_ratio_isr(cam_play_t *p, const cam_play_config_t *cfg)
{
    p->plan.ratio_place =
        cam_eval_place(&cfg->table->speed, p->plan.ratio_angle_q32, p->plan.ratio_height);
    return 0;
}

uint32_t cam_modulate_read_knot_isr(cam_play_t *p, uint32_t end)
{
    p->plan.ratio_knot[end] = cam_eval_knot_at(&p->plan.ratio_place, end);
    return 0;
}

uint32_t cam_modulate_read_ratio_isr(cam_play_t *p)
{
    const cam_segment_t at = {.k0 = p->plan.ratio_knot[0],
                              .k1 = p->plan.ratio_knot[1],
                              .s_q32 = p->plan.ratio_place.s_q32};
    const cam_fine_t fine = cam_eval_quintic(at);
    p->plan.ratio_fine.y = fine.y; // nobody asks for the second derivative
    p->plan.ratio_fine.d1 = fine.d1;
    return 0;
}

uint32_t cam_modulate_scale_ratio_isr(cam_play_t *p, const cam_play_config_t *cfg)
{
    p->plan.ratio =
        cam_speed_scaled(&cfg->table->speed, cam_eval_rounded(p->plan.ratio_fine, false));
    return 0;
}

uint32_t cam_modulate_pace_isr(cam_play_t *p)
{
    p->plan.pace = cam_speed_pace(p->plan.ratio, p->plan.u.envelope);
    return 0;
}

uint32_t cam_modulate_told_isr(cam_play_t *p, const cam_play_config_t *cfg)
{
    p->plan.told_q28 = cam_speed_told_q28(&cfg->speed, p->plan.pace);
    return 0;
}

uint32_t cam_modulate_speed_isr(cam_play_t *p, const cam_play_config_t *cfg)
{
    p->speed.spindle_mrpm = cam_speed_mrpm(&cfg->speed, p->plan.told_q28);
    return 0;
}

uint32_t cam_modulate_alpha_isr(cam_play_t *p, const cam_play_config_t *cfg)
{
    p->speed.alpha_q40 = cam_speed_alpha_q40(&cfg->speed, p->plan.pace);
    return 0;
}

/// U's share of the acceleration that the spindle was told.
uint32_t cam_modulate_alpha_u_isr(cam_play_t *p, const cam_play_config_t *cfg)
{
    p->alpha_u = cam_sat_i32(((int64_t)p->speed.alpha_q40 * p->scale_q30) >> cfg->u.alpha_shift);
    return 0;
}
