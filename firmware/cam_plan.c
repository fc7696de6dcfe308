// SPDX-License-Identifier: Apache-2.0
#include "cam/cam_plan.h"
#include "cam/cam_angle.h" // cam_angle_diff_q32
#include "cam/cam_eval.h"  // cam_eval_profile
#include "cam/cam_fix.h"   // cam_clamp_i32
#include <stddef.h>        // NULL

/// @return the share of one tick in the way of a round
static int32_t share(int32_t way)
{
    return cam_mulhi(way, (int32_t)((INT64_C(1) << 32) / cam_plan_tasks));
}

int32_t cam_plan_smooth_q30(int32_t s_q31)
{
    const int32_t s2_q31 = 2 * cam_mulhi(s_q31, s_q31);
    const int32_t s3_q31 = 2 * cam_mulhi(s2_q31, s_q31);
    const uint32_t inner_q28 =
        (UINT32_C(10) << 28) - 15u * ((uint32_t)s_q31 >> 3) + 6u * ((uint32_t)s2_q31 >> 3);
    const uint32_t y_q30 = (uint32_t)(((uint64_t)(uint32_t)s3_q31 * inner_q28) >> 29);
    return y_q30 < UINT32_C(1) << 30 ? (int32_t)y_q30 : INT32_C(1) << 30; // rounding may pass 1
}

/// @return [1 / 2^30] smooth step over `length` from position `at`
static int32_t rise_q30(int64_t pos_q32, int64_t at_q32, int64_t length_q32,
                        uint32_t per_length_q31)
{
    const int64_t done_q32 = pos_q32 - at_q32;
    if (done_q32 <= 0 || done_q32 >= length_q32) { // most of a cut lies outside of both steps
        return done_q32 <= 0 ? 0 : INT32_C(1) << 30;
    }
    const uint32_t done_q24 = (uint32_t)(done_q32 >> 8); // 100 turns at most
    return cam_plan_smooth_q30((int32_t)(((uint64_t)done_q24 * per_length_q31) >> 24));
}

/// @return [1 / 2^30] 0 out of the work, 2^30 at full depth and amplitude
static int32_t envelope_q30(const cam_play_t *p, const cam_play_config_t *cfg, int64_t pos_q32)
{
    const int32_t up = rise_q30(pos_q32, p->engage_at_q32, cfg->engage_q32, cfg->per_engage_q31);
    const int32_t down =
        rise_q30(pos_q32, p->disengage_at_q32, cfg->disengage_q32, cfg->per_disengage_q31);
    return cam_mul_shift(up, (INT32_C(1) << 30) - down, 30);
}

/// @return [turn] fed after `turns` when the feed rises linearly over the ramp r: x^2 / 2r, x - r/2
static int64_t eased_q32(const cam_play_config_t *cfg, int64_t turns_q32)
{
    if (turns_q32 >= cfg->ramp_q32) {
        return turns_q32 - cfg->ramp_q32 / 2;
    }
    const int64_t turns_q24 = turns_q32 >> 8;
    const int64_t share_q31 = (turns_q24 * cfg->per_ramp_q31) >> 24;
    return (share_q31 * turns_q24) >> 24;
}

/// @return [nm] height at a master position; the feed rises at its start and falls towards its end
static int32_t height_nm(const cam_play_t *p, const cam_play_config_t *cfg, int64_t pos_q32)
{
    const int64_t done_q32 = cam_clamp_i64(pos_q32 - p->feed_at_q32, 0, p->feed_turns_q32);
    const int64_t left_q32 = p->feed_turns_q32 - done_q32;
    const int64_t fed_q32 = done_q32 <= left_q32
                                ? eased_q32(cfg, done_q32)
                                : p->feed_turns_q32 - cfg->ramp_q32 - eased_q32(cfg, left_q32);
    return cfg->z_first_nm + (int32_t)((fed_q32 * cfg->feed_nm + (INT64_C(1) << 31)) >> 32);
}

int64_t cam_plan_profile_q10(const cam_play_config_t *cfg, int32_t z_nm)
{
    const cam_channel_t *x = &cfg->table->x;
    return (((int64_t)cam_eval_profile(x, z_nm).y * 1024) >> x->frac_bits) +
           (int64_t)x->offset_nm * 1024;
}

/// Phase and amplitude on their way to what the operator set, as far as the ticks of a round go.
CAM_STAGE static uint32_t ramp(cam_play_t *p, const cam_play_config_t *cfg)
{
    const int32_t most_q32 = cfg->phase_step_q32;
    const int32_t left_q32 = cam_angle_diff_q32((uint32_t)cfg->phase_q32, (uint32_t)p->phase_q32);
    p->phase_way_q32 = cam_clamp_i32(share(left_q32), -most_q32, most_q32);
    if (p->phase_way_q32 == 0) {
        p->phase_q32 = cfg->phase_q32;
    }
    const int32_t most_q30 = cfg->amplitude_step_q30 * cam_plan_tasks;
    p->amplitude_q30 += cam_clamp_i32(cfg->amplitude_q30 - p->amplitude_q30, -most_q30, most_q30);
    return 0;
}

static cam_state_t state_at(const cam_play_t *p, const cam_play_config_t *cfg, int64_t pos_q32)
{
    if (pos_q32 >= p->disengage_at_q32) {
        return pos_q32 < p->disengage_at_q32 + cfg->disengage_q32 ? cam_state_disengaging
                                                                  : cam_state_ready;
    }
    return pos_q32 < p->feed_at_q32 ? cam_state_engaging : cam_state_cutting;
}

/// Where the axes shall be at the end of the ways that are made in this round.
CAM_STAGE static uint32_t plan_height(cam_play_t *p, const cam_play_config_t *cfg,
                                      const cam_sense_t *in, const cam_angle_t *angle)
{
    const int64_t spindle_lag_q32 = ((int64_t)p->speed.alpha_q40 * cfg->xz_lag2) >> 8;
    const int32_t z_nm = in->actual_nm[hal_axis_z];
    const int32_t going_on_nm = cam_sat_i32(2 * (int64_t)z_nm - p->measured_z_nm);
    p->plan_pos_q32 = cam_angle_ahead(angle, cfg->xz_plan_q16) + spindle_lag_q32;
    p->plan_z_nm = cfg->is_z_measured ? going_on_nm : height_nm(p, cfg, p->plan_pos_q32);
    p->measured_z_nm = z_nm;
    return 0;
}

/// X at the planned height.
CAM_STAGE static uint32_t plan_x(cam_play_t *p, const cam_play_config_t *cfg)
{
    const int32_t out_q30 = (INT32_C(1) << 30) - p->x_envelope_q30;
    const int64_t clear_q10 = ((int64_t)cfg->x_clearance_nm * out_q30) >> 20;
    p->plan_x_q10 = cam_plan_profile_q10(cfg, p->plan_z_nm) + clear_q10;
    return 0;
}

/// Equal ways to a target; what does not divide is gone at once.
static void aim(cam_move_t *m, int64_t target_q10)
{
    const int64_t left_q10 = target_q10 - m->pos_q10;
    m->vel_q10 = share(cam_sat_i32(left_q10));
    m->acc_q10 = 0;
    m->pos_q10 += left_q10 - (int64_t)m->vel_q10 * cam_plan_tasks;
}

CAM_STAGE static uint32_t aim_all(cam_play_t *p, const cam_play_config_t *cfg)
{
    aim(&p->axis[hal_axis_x], p->plan_x_q10);
    aim(&p->axis[hal_axis_z], (int64_t)p->plan_z_nm * 1024);
    const int32_t scale_q30 = cam_mul_shift(p->u_envelope_q30, p->amplitude_q30, 30);
    p->scale_way_q30 = share(scale_q30 - p->scale_q30);
    p->scale_q30 = scale_q30 - p->scale_way_q30 * cam_plan_tasks;
    const int32_t z_vel_q10 = p->axis[hal_axis_z].vel_q10;
    p->z_behind_nm = (int32_t)(((int64_t)z_vel_q10 * cfg->u_behind_q16) >> 26);
    return 0;
}

/// The speed ratio at the middle of the ticks that will use it, seen from this one.
CAM_STAGE static uint32_t place_ratio(cam_play_t *p, const cam_play_config_t *cfg,
                                      const cam_angle_t *angle)
{
    const cam_channel_t *speed = &cfg->table->speed;
    const int32_t later_q16 = cfg->lead_q16 + (13 << 15); // 6 1/2 ticks
    const uint32_t later_q32 = cam_angle_of_pos(cam_angle_ahead(angle, later_q16));
    p->ratio_at = cam_eval_segment(speed, later_q32 - (uint32_t)p->phase_q32,
                                   cam_eval_height(speed, p->plan_z_nm));
    return 0;
}

CAM_STAGE static uint32_t read_ratio(cam_play_t *p, const cam_play_config_t *cfg)
{
    const cam_value_t value = cam_eval_rounded(cam_eval_quintic(p->ratio_at), false);
    p->ratio = cam_speed_scaled(&cfg->table->speed, value);
    return 0;
}

/// The spindle from its own angle.
CAM_STAGE static uint32_t set_speed(cam_play_t *p, const cam_play_config_t *cfg)
{
    p->speed = cam_speed_law(&cfg->speed, p->ratio, p->u_envelope_q30);
    p->alpha_u = cam_sat_i32(((int64_t)p->speed.alpha_q40 * p->scale_q30) >> cfg->u.alpha_shift);
    return 0;
}

/// Measured Z must lie on the table, a geared one moreover where its set-point was one lag ago.
CAM_STAGE static uint32_t range_fault(const cam_play_config_t *cfg, const cam_sense_t *in,
                                      const cam_move_t *z)
{
    const int32_t z_nm = in->actual_nm[hal_axis_z];
    const int64_t due_q10 = z->pos_q10 - (((int64_t)z->vel_q10 * cfg->xz_lag_q16) >> 16);
    const int64_t off_nm = z_nm - (due_q10 >> 10);
    const bool is_off = !cfg->is_z_measured && cam_abs_i64(off_nm) > cfg->z_margin_nm;
    const bool is_out = z_nm < cfg->z_low_nm || z_nm > cfg->z_high_nm;
    return is_off || is_out ? CAM_FAULT_BIT(z_range) : 0u;
}

CAM_STAGE static uint32_t plan_x_envelope(cam_play_t *p, const cam_play_config_t *cfg)
{
    p->x_envelope_q30 = envelope_q30(p, cfg, p->plan_pos_q32);
    return 0;
}

CAM_STAGE static uint32_t plan_u_envelope(cam_play_t *p, const cam_play_config_t *cfg,
                                          const cam_angle_t *angle)
{
    p->u_envelope_q30 = envelope_q30(p, cfg, cam_angle_ahead(angle, cfg->u_plan_q16));
    return 0;
}

/// The state at the spindle itself, and whether Z is where it should be.
CAM_STAGE static uint32_t look_round(cam_play_t *p, const cam_play_config_t *cfg,
                                     const cam_sense_t *in, const cam_angle_t *angle)
{
    p->state = state_at(p, cfg, angle->pos_q32);
    if (p->state == cam_state_ready) { // scale 0: U has come to rest at 0
        p->axis[hal_axis_u] = (cam_move_t){0};
    }
    return range_fault(cfg, in, &p->axis[hal_axis_z]);
}

/// What a table without a speed channel costs is one question.
uint32_t cam_plan_task_isr(cam_play_t *p, const cam_play_config_t *cfg, const cam_sense_t *in,
                           const cam_angle_t *angle)
{
    const uint32_t task = p->task;
    p->task = task == cam_plan_tasks - 1u ? 0u : task + 1u;
    switch (task) {
    case 0:
        return plan_height(p, cfg, in, angle);
    case 1:
        return plan_x_envelope(p, cfg);
    case 2:
        return plan_u_envelope(p, cfg, angle);
    case 3:
        return plan_x(p, cfg);
    case 4:
        return aim_all(p, cfg);
    case 5:
        return cfg->table->speed.knots != NULL ? place_ratio(p, cfg, angle) : 0u;
    case 6:
        return cfg->table->speed.knots != NULL ? read_ratio(p, cfg) : 0u;
    case 7:
        return cfg->table->speed.knots != NULL ? set_speed(p, cfg) : 0u;
    case 8:
        return look_round(p, cfg, in, angle);
    default:
        return ramp(p, cfg);
    }
}
