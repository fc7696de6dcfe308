// SPDX-License-Identifier: Apache-2.0
#include "cam_plan.h"
#include "cam_angle.h"    // cam_angle_diff_q32
#include "cam_fix.h"      // cam_clamp_i32
#include "cam_modulate.h" // cam_modulate_find_slices_isr ..
#include "cam_play.h"     // cam_play_t

/// Half a nanometre: what is read in whole ones is then rounded.
#define HALF_NM_Q10 512

/// Ticks by which a way may last longer: two rounds of the most that may be put off are fewer.
enum { most_longer = 256 };
_Static_assert(most_longer > 2 * (cam_plan_most_ticks + cam_plan_put_off), "two rounds");

/// [1] in the unit of envelopes.
#define ONE_Q30 (INT32_C(1) << 30)

/// @return [ticks] of this round that had no task
static int32_t put_off(const cam_play_t *p, const cam_play_config_t *cfg)
{
    return cfg->most_put_off - p->put_off_left;
}

/// @return the share of one tick in the way of a round
static int32_t share(const cam_play_config_t *cfg, int32_t way)
{
    return cam_mulhi(way, cfg->per_round_q32);
}

int32_t cam_plan_smooth_q30(int32_t s_q31)
{
    const int32_t s2_q31 = 2 * cam_mulhi(s_q31, s_q31);
    const int32_t s3_q31 = 2 * cam_mulhi(s2_q31, s_q31);
    const uint32_t inner_q28 =
        (UINT32_C(10) << 28) - 15u * ((uint32_t)s_q31 >> 3) + 6u * ((uint32_t)s2_q31 >> 3);
    const uint32_t y_q30 = (uint32_t)(((uint64_t)(uint32_t)s3_q31 * inner_q28) >> 29);
    return y_q30 < UINT32_C(1) << 30 ? (int32_t)y_q30 : ONE_Q30; // rounding may pass 1
}

/// @return [1 / 2^30] smooth step over `length`, `done` behind its begin
static int32_t rise_q30(int64_t done_q32, int64_t length_q32, uint32_t per_length_q31)
{
    if (done_q32 <= 0 || done_q32 >= length_q32) { // most of a cut lies outside of both steps
        return done_q32 <= 0 ? 0 : ONE_Q30;
    }
    const uint32_t done_q24 = (uint32_t)(done_q32 >> 8); // 100 turns at most
    return cam_plan_smooth_q30((int32_t)(((uint64_t)done_q24 * per_length_q31) >> 24));
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

/// Where the master will be, seen from each axis, at the end of the ways that this round makes.
CAM_STAGE static uint32_t plan_positions(cam_play_t *p, const cam_play_config_t *cfg,
                                         const cam_sense_t *in, const cam_angle_t *angle)
{
    const int64_t spindle_lag_q32 = ((int64_t)p->speed.alpha_q40 * cfg->xz_lag2) >> 8;
    const int32_t z_nm = in->actual_nm[hal_axis_z];
    p->plan.xz.pos_q32 = cam_angle_ahead(angle, cfg->xz_plan_q16) + spindle_lag_q32;
    p->plan.u.pos_q32 = cam_angle_ahead(angle, cfg->u_plan_q16);
    p->plan.going_on_nm = cam_wrap_add(z_nm, cam_wrap_sub(z_nm, p->plan.measured_nm));
    p->plan.measured_nm = z_nm;
    p->put_off_left = cfg->most_put_off;
    p->task = 1; // behind the last task of a round it stands again
    return 0;
}

CAM_STAGE static uint32_t plan_turns(cam_play_t *p)
{
    p->plan.done_q32 = cam_clamp_i64(p->plan.xz.pos_q32 - p->feed_at_q32, 0, p->feed_turns_q32);
    return 0;
}

/// The feed rises at its start and falls towards its end.
CAM_STAGE static uint32_t plan_feed(cam_play_t *p, const cam_play_config_t *cfg)
{
    const int64_t done_q32 = p->plan.done_q32;
    if (cfg->rings.is_on) {
        p->plan.risen_q30 = cam_feed_risen_q30_isr(&cfg->rings, done_q32);
        return 0;
    }
    const int64_t left_q32 = p->feed_turns_q32 - done_q32;
    p->plan.fed_q32 = done_q32 <= left_q32
                          ? eased_q32(cfg, done_q32)
                          : p->feed_turns_q32 - cfg->ramp_q32 - eased_q32(cfg, left_q32);
    return 0;
}

CAM_STAGE static uint32_t plan_height(cam_play_t *p, const cam_play_config_t *cfg)
{
    if (cfg->rings.is_on) {
        p->plan.z_nm = cfg->z_first_nm +
                       cam_feed_height_nm_isr(&cfg->rings, p->plan.done_q32, p->plan.risen_q30);
        return 0;
    }
    const int64_t fed_nm = (p->plan.fed_q32 * cfg->feed_nm + (INT64_C(1) << 31)) >> 32;
    p->plan.z_nm = cfg->is_z_measured ? p->plan.going_on_nm : cfg->z_first_nm + (int32_t)fed_nm;
    return 0;
}

/// The rising part of an envelope.
CAM_STAGE static uint32_t plan_rise(const cam_play_t *p, const cam_play_config_t *cfg,
                                    cam_plan_depth_t *at)
{
    at->risen = rise_q30(at->pos_q32 - p->engage_at_q32, cfg->engage_q32, cfg->per_engage_q31);
    return 0;
}

/// The falling part.
CAM_STAGE static uint32_t plan_fall(const cam_play_t *p, const cam_play_config_t *cfg,
                                    cam_plan_depth_t *at)
{
    at->fallen =
        rise_q30(at->pos_q32 - p->disengage_at_q32, cfg->disengage_q32, cfg->per_disengage_q31);
    return 0;
}

static void finish_envelope(cam_plan_depth_t *at)
{
    at->envelope = cam_mul_shift(at->risen, ONE_Q30 - at->fallen, 30);
}

CAM_STAGE static uint32_t plan_envelopes(cam_play_t *p)
{
    finish_envelope(&p->plan.xz);
    finish_envelope(&p->plan.u);
    return 0;
}

CAM_STAGE static uint32_t find_profile(cam_play_t *p, const cam_play_config_t *cfg)
{
    p->plan.x_spot = cam_eval_spot(&cfg->table->x, p->plan.z_nm);
    return 0;
}

CAM_STAGE static uint32_t read_profile(cam_play_t *p)
{
    p->plan.x_value = cam_eval_profile_at(p->plan.x_spot).y;
    return 0;
}

CAM_STAGE static uint32_t plan_x(cam_play_t *p, const cam_play_config_t *cfg)
{
    const int64_t clear_q10 =
        ((int64_t)cfg->x_clearance_nm * (ONE_Q30 - p->plan.xz.envelope)) >> 20;
    p->plan.x_q10 = cam_plan_profile_q10(&cfg->table->x, p->plan.x_value) + clear_q10 + HALF_NM_Q10;
    return 0;
}

/// Equal ways to a target; what does not divide is gone at once. The end of the way has been put
/// off by as many ticks as the round. Two millimetres per round are the most: a Z that others move
/// faster is followed later.
static void aim(cam_move_t *m, const cam_play_config_t *cfg, int32_t n_put_off, int64_t target_q10)
{
    const int64_t put_off_q10 = (int64_t)m->vel_q10 * n_put_off;
    const int32_t left_q10 = cam_sat_i32(target_q10 + put_off_q10 - m->pos_q10);
    m->vel_q10 = share(cfg, left_q10);
    m->acc_q10 = 0;
    m->pos_q10 += left_q10 - (int64_t)m->vel_q10 * cfg->round_ticks;
}

/// X's way ends before Z's, for which it was planned.
CAM_STAGE static uint32_t aim_x(cam_play_t *p, const cam_play_config_t *cfg)
{
    cam_move_t *x = &p->axis[hal_axis_x];
    aim(x, cfg, put_off(p, cfg) - cfg->x_early_ticks, p->plan.x_q10);
    return 0;
}

CAM_STAGE static uint32_t aim_z(cam_play_t *p, const cam_play_config_t *cfg)
{
    aim(&p->axis[hal_axis_z], cfg, put_off(p, cfg), (int64_t)p->plan.z_nm * 1024);
    return 0;
}

/// U's height on the table.
CAM_STAGE static uint32_t find_height(cam_play_t *p, const cam_play_config_t *cfg)
{
    const int64_t ahead_q26 = (int64_t)p->axis[hal_axis_z].vel_q10 * cfg->u_height_q16;
    const int32_t z_nm = cam_wrap_add(p->plan.z_nm, (int32_t)(ahead_q26 >> 26));
    cam_plan_keep_height(&p->plan.u_height, cam_eval_height(&cfg->table->u, z_nm));
    return 0;
}

CAM_STAGE static uint32_t hold_height(cam_play_t *p, const cam_play_config_t *cfg,
                                      const cam_angle_t *angle)
{
    p->plan.free_q32 = cam_angle_next_turn(cam_angle_ahead(angle, cfg->free_q16));
    const cam_height_t at = p->plan.u_height;
    const int64_t found_q32 = (int64_t)((uint64_t)at.i << 32 | (uint32_t)at.w_q31 << 1);
    const int64_t put_off_q32 = (int64_t)p->height_way_q32 * put_off(p, cfg);
    p->plan.u_height_q32 = cam_clamp_i64(found_q32 + put_off_q32, 0, cfg->height_max_q32);
    return 0;
}

/// Eight slices per round are the most: nothing that feeds is as fast. The way is rounded towards
/// 0, so that what is gone at once is gone towards the target: U never leaves the table.
CAM_STAGE static uint32_t aim_height(cam_play_t *p, const cam_play_config_t *cfg)
{
    const int64_t target_q32 = p->plan.u_height_q32;
    const int32_t left_q28 = cam_sat_i32((target_q32 - p->height_q32) >> 4);
    const uint32_t per_round_q32 = (uint32_t)cfg->per_round_q32;
    const uint32_t sign =
        left_q28 < 0 ? UINT32_MAX : 0u; // of a product of a signed and an unsigned one
    const uint32_t floor_q28 =
        cam_mulhi_u32((uint32_t)left_q28, per_round_q32) - (sign & per_round_q32);
    const int32_t way_q32 = (int32_t)(floor_q28 - sign) * 16;
    const int64_t longest_q32 = target_q32 + (int64_t)way_q32 * most_longer;
    p->is_height_free = (uint64_t)longest_q32 <= (uint64_t)cfg->height_max_q32; // and not below 0
    p->height_way_q32 = way_q32;
    p->height_q32 = target_q32 - (int64_t)way_q32 * cfg->round_ticks;
    return 0;
}

/// U's amplitude, and how far behind Z's set-point U is played.
CAM_STAGE static uint32_t aim_u(cam_play_t *p, const cam_play_config_t *cfg)
{
    const int32_t scale_q30 = cam_mul_shift(p->plan.u.envelope, p->amplitude_q30, 30);
    p->scale_way_q30 = share(cfg, scale_q30 - p->scale_q30);
    p->scale_q30 = scale_q30 - p->scale_way_q30 * cfg->round_ticks;
    const int64_t behind_q26 = (int64_t)p->axis[hal_axis_z].vel_q10 * cfg->u_behind_q16;
    const int32_t behind_q4 = (int32_t)(behind_q26 >> 22);
    p->behind_way_q4 = share(cfg, behind_q4 - p->behind_q4);
    p->behind_q4 = behind_q4 - p->behind_way_q4 * cfg->round_ticks;
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

/// Where a stop would end the feed, and behind it the cut: on a whole turn that no axis is told of
/// before this task comes again. A feed in motion falls over its ramp, a ring-helix goes on to the
/// end of the next ring, a feed that has not begun does not begin.
static void plan_stop(cam_play_t *p, const cam_play_config_t *cfg)
{
    const int64_t fed_q32 = p->plan.free_q32 - p->feed_at_q32;
    const int64_t ramp_q32 = cfg->ramp_q32;
    p->plan.stop_turns_q32 = 0;
    p->plan.stop_end_q32 = p->plan.free_q32;
    if (fed_q32 > 0 && !cfg->is_z_measured) {
        const int64_t turns_q32 = cfg->rings.is_on     ? cam_feed_ring_end_q32(fed_q32)
                                  : fed_q32 > ramp_q32 ? fed_q32 + ramp_q32
                                                       : 2 * ramp_q32;
        p->plan.stop_turns_q32 = turns_q32;
        p->plan.stop_end_q32 = p->feed_at_q32 + turns_q32;
    }
}

/// The state is that of the spindle itself, not of what is planned.
CAM_STAGE static uint32_t look_at_state(cam_play_t *p, const cam_play_config_t *cfg,
                                        const cam_angle_t *angle)
{
    plan_stop(p, cfg);
    p->state = state_at(p, cfg, angle->pos_q32);
    if (p->state == cam_state_ready) { // scale 0: U has come to rest at 0
        p->axis[hal_axis_u] = (cam_move_t){0};
        p->is_playing = false;
    }
    return 0;
}

/// Measured Z must lie on the table, a geared one moreover where its set-point was one lag ago.
CAM_STAGE static uint32_t look_at_z(const cam_play_config_t *cfg, const cam_sense_t *in,
                                    const cam_move_t *z)
{
    const int32_t z_nm = in->actual_nm[hal_axis_z];
    const int64_t due_q10 = z->pos_q10 - (((int64_t)z->vel_q10 * cfg->xz_lag_q16) >> 16);
    const int64_t off_nm = z_nm - (due_q10 >> 10);
    const bool is_off = !cfg->is_z_measured && cam_abs_i64(off_nm) > cfg->z_margin_nm;
    const bool is_out = z_nm < cfg->z_low_nm || z_nm > cfg->z_high_nm;
    return is_off || is_out ? CAM_FAULT_BIT(z_range) : 0u;
}

/// Phase and amplitude on their way to what the operator set, as far as the ticks of a round go.
CAM_STAGE static uint32_t ramp(cam_play_t *p, const cam_play_config_t *cfg)
{
    const int32_t most_q32 = cfg->phase_step_q32;
    const int32_t left_q32 = cam_angle_diff_q32((uint32_t)cfg->phase_q32, (uint32_t)p->phase_q32);
    p->phase_way_q32 = cam_clamp_i32(share(cfg, left_q32), -most_q32, most_q32);
    if (p->phase_way_q32 == 0) {
        p->phase_q32 = cfg->phase_q32;
    }
    const int32_t most_q30 = cfg->amplitude_step_q30 * cfg->round_ticks;
    p->amplitude_q30 += cam_clamp_i32(cfg->amplitude_q30 - p->amplitude_q30, -most_q30, most_q30);
    return 0;
}

/// The swing's, where all axes will be.
CAM_STAGE static uint32_t find_swing_height(cam_play_t *p, const cam_play_config_t *cfg)
{
    cam_plan_keep_height(&p->swing.height, cam_eval_height(&cfg->table->angle, p->plan.z_nm));
    return 0;
}

// One list of a round's tasks: a second switch behind it would cost the longest tick.
// NOLINTNEXTLINE(readability-function-size)
uint32_t cam_plan_task_isr(cam_play_t *p, const cam_play_config_t *cfg, const cam_sense_t *in,
                           const cam_angle_t *angle)
{
    const uint32_t place = p->task;
    p->task = place + 1u;
    switch (cfg->schedule[place]) {
    case cam_plan_task_positions:
        return plan_positions(p, cfg, in, angle);
    case cam_plan_task_turns:
        return plan_turns(p);
    case cam_plan_task_feed:
        return plan_feed(p, cfg);
    case cam_plan_task_height:
        return plan_height(p, cfg);
    case cam_plan_task_x_rise:
        return plan_rise(p, cfg, &p->plan.xz);
    case cam_plan_task_x_fall:
        return plan_fall(p, cfg, &p->plan.xz);
    case cam_plan_task_u_rise:
        return plan_rise(p, cfg, &p->plan.u);
    case cam_plan_task_u_fall:
        return plan_fall(p, cfg, &p->plan.u);
    case cam_plan_task_envelopes:
        return plan_envelopes(p);
    case cam_plan_task_find_profile:
        return find_profile(p, cfg);
    case cam_plan_task_read_profile:
        return read_profile(p);
    case cam_plan_task_x:
        return plan_x(p, cfg);
    case cam_plan_task_aim_x:
        return aim_x(p, cfg);
    case cam_plan_task_aim_z:
        return aim_z(p, cfg);
    case cam_plan_task_find_height:
        return find_height(p, cfg);
    case cam_plan_task_hold_height:
        return hold_height(p, cfg, angle);
    case cam_plan_task_aim_height:
        return aim_height(p, cfg);
    case cam_plan_task_aim_u:
        return aim_u(p, cfg);
    case cam_plan_task_state:
        return look_at_state(p, cfg, angle);
    case cam_plan_task_z:
        return look_at_z(cfg, in, &p->axis[hal_axis_z]);
    case cam_plan_task_ramp:
        return ramp(p, cfg);
    case cam_plan_task_find_slices:
        return cam_modulate_find_slices_isr(p, cfg, angle);
    case cam_plan_task_find_ratio:
        return cam_modulate_find_ratio_isr(p, cfg);
    case cam_plan_task_ratio_knot_0:
        return cam_modulate_read_knot_isr(p, 0);
    case cam_plan_task_ratio_knot_1:
        return cam_modulate_read_knot_isr(p, 1);
    case cam_plan_task_read_ratio:
        return cam_modulate_read_ratio_isr(p);
    case cam_plan_task_ratio:
        return cam_modulate_scale_ratio_isr(p, cfg);
    case cam_plan_task_pace:
        return cam_modulate_pace_isr(p);
    case cam_plan_task_told:
        return cam_modulate_told_isr(p, cfg);
    case cam_plan_task_speed:
        return cam_modulate_speed_isr(p, cfg);
    case cam_plan_task_alpha:
        return cam_modulate_alpha_isr(p, cfg);
    case cam_plan_task_alpha_u:
        return cam_modulate_alpha_u_isr(p, cfg);
    case cam_plan_task_height_swing:
        return find_swing_height(p, cfg);
    case cam_plan_task_look_at_swing:
        return cam_swing_look_isr(&p->swing, &cfg->swing, in->swing_q32, p->n_history);
    case cam_plan_task_find_swing:
        return cam_swing_find_isr(&p->swing, &cfg->swing, angle, p->phase_q32, p->n_history);
    case cam_plan_task_place_swing:
        return cam_swing_place_isr(&p->swing, &cfg->table->angle);
    case cam_plan_task_swing_knot_0:
        return cam_swing_knot_isr(&p->swing, 0);
    case cam_plan_task_swing_knot_1:
        return cam_swing_knot_isr(&p->swing, 1);
    case cam_plan_task_read_swing:
        return cam_swing_read_isr(&p->swing, &cfg->swing);
    default:
        return cam_swing_aim_isr(&p->swing, &cfg->swing, p->scale_q30, p->n_history);
    }
}
