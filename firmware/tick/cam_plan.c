// SPDX-License-Identifier: Apache-2.0
#include "cam_plan.h"
#include "cam_angle.h" // cam_angle_diff_q32
#include "cam_eval.h"  // cam_eval_profile
#include "cam_fix.h"   // cam_clamp_i32
#include "cam_swing.h" // cam_swing_aim_isr

/// Half a nanometre: what is read in whole ones is then rounded.
#define HALF_NM_Q10 512

/// [1] in the unit of envelopes.
#define ONE_Q30 (INT32_C(1) << 30)

/// Disengage position of a cut that only stop ends.
#define NEVER_Q32 (INT64_MAX / 2)

/// @return the share of one tick in what is left until the next plan
static int32_t share(const cam_play_config_t *cfg, int32_t left)
{
    return cam_mul_shift(left, cfg->per_plan_q30, 30);
}

/// @return [turn] where the master will be, the acceleration of the spindle allowed for
static int64_t ahead_q32(const cam_angle_t *angle, int32_t ticks_q16, int32_t alpha_q40,
                         int32_t ticks2)
{
    return cam_angle_ahead(angle, ticks_q16) + (((int64_t)alpha_q40 * ticks2) >> 8);
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

/// What a drive with a lag must be commanded on top of the smooth step s to follow it. A drive of
/// two equal poles of half the lag each is inverted by lag s' + (lag / 2)^2 s''; d is the lag as a
/// share of the step:
///     d (30 q^2 + 15 d q (1 - 2 s)),   q = s (1 - s)
/// @param s_q31  [1 / 2^31] 0 .. 2^31 - 1
/// @param d_q31  [1 / 2^31] 0 .. 2^31 / 16
/// @return       [1 / 2^30]
static int32_t inverse_q30(int32_t s_q31, int32_t d_q31)
{
    const int32_t q_q31 = 2 * cam_mulhi(s_q31, INT32_MAX - s_q31);
    const int32_t slope_q31 = (int32_t)((uint32_t)INT32_MAX - 2u * (uint32_t)s_q31);
    const int32_t bend_q31 = 2 * cam_mulhi(d_q31, slope_q31);
    const int32_t sum_q30 = 30 * cam_mulhi(q_q31, q_q31) + 15 * cam_mulhi(q_q31, bend_q31);
    return 2 * cam_mulhi(sum_q30, d_q31);
}

/// Smooth step over `length`, `done` behind its begin, as a drive must be commanded to follow it
/// whose lag is `lag`. Up to a sixteenth of the length is inverted, then the command overshoots the
/// end by at most 12 / 16^3 of the step; what the lag has more is made up for by reading ahead.
/// @return [1 / 2^30]
static int32_t rise_q30(int64_t done_q32, int64_t lag_q32, int64_t length_q32,
                        uint32_t per_length_q31)
{
    const int64_t inverted_q32 = cam_clamp_i64(lag_q32, 0, length_q32 / 16);
    const int64_t at_q32 = done_q32 + lag_q32 - inverted_q32;
    if (at_q32 <= 0 || at_q32 >= length_q32) { // most of a cut lies outside of both steps
        return at_q32 <= 0 ? 0 : ONE_Q30;
    }
    const uint32_t at_q24 = (uint32_t)(at_q32 >> 8); // 100 turns at most
    const uint32_t lag_q24 = (uint32_t)(inverted_q32 >> 8);
    const int32_t s_q31 = (int32_t)(((uint64_t)at_q24 * per_length_q31) >> 24);
    const int32_t d_q31 = (int32_t)(((uint64_t)lag_q24 * per_length_q31) >> 24);
    return cam_plan_smooth_q30(s_q31) + inverse_q30(s_q31, d_q31);
}

/// @param lag_q32  [turn] travelled during the lag of the drive
/// @return         [1 / 2^30] 0 out of the work, 2^30 at full depth and amplitude
static int32_t envelope_q30(const cam_plan_t *p, const cam_play_config_t *cfg, int64_t pos_q32,
                            int64_t lag_q32)
{
    const int32_t risen_q30 =
        rise_q30(pos_q32 - p->engage_at_q32, lag_q32, cfg->engage_q32, cfg->per_engage_q31);
    const int32_t fallen_q30 = rise_q30(pos_q32 - p->disengage_at_q32, lag_q32, cfg->disengage_q32,
                                        cfg->per_disengage_q31);
    return cam_mul_shift(risen_q30, ONE_Q30 - fallen_q30, 30);
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

/// @return [nm] Z above the first height: the feed rises at its start and falls towards its end
static int32_t fed_nm(const cam_plan_t *p, const cam_play_config_t *cfg, int64_t pos_q32)
{
    const int64_t done_q32 = cam_clamp_i64(pos_q32 - p->feed_at_q32, 0, p->feed_turns_q32);
    if (cfg->rings.is_on) {
        return cam_feed_height_nm_isr(&cfg->rings, done_q32,
                                      cam_feed_risen_q30_isr(&cfg->rings, done_q32));
    }
    const int64_t left_q32 = p->feed_turns_q32 - done_q32;
    const int64_t fed_q32 = done_q32 <= left_q32
                                ? eased_q32(cfg, done_q32)
                                : p->feed_turns_q32 - cfg->ramp_q32 - eased_q32(cfg, left_q32);
    return (int32_t)((fed_q32 * cfg->feed_nm + (INT64_C(1) << 31)) >> 32);
}

/// @return [nm] Z at the next plan; one that others lead goes on as it did since the last plan
static int32_t height_nm(cam_plan_t *p, const cam_play_config_t *cfg, int32_t actual_nm,
                         int64_t pos_q32)
{
    const int32_t moved_nm = cam_wrap_sub(actual_nm, p->measured_nm);
    p->measured_nm = actual_nm;
    return cfg->is_z_measured ? cam_wrap_add(actual_nm, moved_nm)
                              : cfg->z_first_nm + fed_nm(p, cfg, pos_q32);
}

/// @return [nm / 1024] X over a height, clear of the work by what the envelope leaves
static int64_t profile_q10(const cam_play_config_t *cfg, int32_t z_nm, int32_t envelope)
{
    const int64_t clear_q10 = ((int64_t)cfg->x_clearance_nm * (ONE_Q30 - envelope)) >> 20;
    return cam_plan_profile_q10(&cfg->table->x, cam_eval_profile(&cfg->table->x, z_nm).y) +
           clear_q10;
}

/// Equal increments to a target; what does not divide is gone at once. Two millimetres per plan are
/// the most: a Z that others move faster is followed later.
static void aim(cam_move_t *m, const cam_play_config_t *cfg, int64_t target_q10)
{
    const int32_t left_q10 = cam_sat_i32(target_q10 - m->pos_q10);
    m->vel_q10 = share(cfg, left_q10);
    m->acc_q10 = 0;
    m->pos_q10 += left_q10 - (int64_t)m->vel_q10 * cfg->plan_ticks;
}

/// @return [slices] of U at a height
static int64_t slice_q32(const cam_play_config_t *cfg, int32_t z_nm)
{
    const cam_height_t at = cam_eval_height(&cfg->table->u, z_nm);
    const int64_t found_q32 = (int64_t)((uint64_t)at.i << 32 | (uint32_t)at.w_q31 << 1);
    return cam_clamp_i64(found_q32, 0, cfg->height_max_q32);
}

/// U's height on the table. Eight slices per plan are the most: no feed is as fast. The increment
/// is rounded towards 0, so that what is gone at once is gone towards the target: U never leaves
/// the table.
static void aim_height(cam_motion_t *m, const cam_play_config_t *cfg, int64_t target_q32)
{
    const int32_t left_q28 = cam_sat_i32((target_q32 - m->height_q32) >> 4);
    const int64_t step_q58 = (int64_t)left_q28 * cfg->per_plan_q30;
    const int32_t step_q28 = (int32_t)((step_q58 < 0 ? step_q58 + ONE_Q30 - 1 : step_q58) >> 30);
    m->height_step_q32 = step_q28 * 16;
    m->height_q32 = target_q32 - (int64_t)m->height_step_q32 * cfg->plan_ticks;
}

/// @return [nm] where Z itself will be when U has moved to what it is commanded at the next plan.
/// It is read off the feed at that instant. Taking Z's set-point less its speed times its lag comes
/// to the same, but it multiplies the noise of the observed speed by the lag once more, which U
/// shows where the table is steep over the height.
static int32_t u_height_nm(const cam_plan_t *p, const cam_play_config_t *cfg, int64_t pos_q32,
                           int32_t z_nm, int32_t z_vel_q10)
{
    return cfg->is_z_measured
               ? cam_wrap_add(z_nm, (int32_t)(((int64_t)z_vel_q10 * cfg->lead_q16) >> 26))
               : cfg->z_first_nm + fed_nm(p, cfg, pos_q32);
}

/// U's amplitude, its height on the table, and how far that is behind Z's set-point.
static void aim_u(cam_motion_t *m, const cam_play_config_t *cfg, int32_t scale_q30, int32_t z_nm,
                  int32_t u_z_nm)
{
    const int32_t behind_q4 = cam_sat_i32((int64_t)cam_wrap_sub(z_nm, u_z_nm) * 16);
    m->scale_step_q30 = share(cfg, scale_q30 - m->scale_q30);
    m->scale_q30 = scale_q30 - m->scale_step_q30 * cfg->plan_ticks;
    m->behind_step_q4 = share(cfg, cam_wrap_sub(behind_q4, m->behind_q4));
    m->behind_q4 = behind_q4 - m->behind_step_q4 * cfg->plan_ticks;
    aim_height(m, cfg, slice_q32(cfg, u_z_nm));
}

/// @return [turn / 2^32] the operator's phase at the next plan
static uint32_t phase_then_q32(const cam_motion_t *m, const cam_play_config_t *cfg)
{
    return (uint32_t)m->phase_q32 + (uint32_t)m->phase_step_q32 * (uint32_t)cfg->plan_ticks;
}

/// Spindle: the speed ratio moves linearly to that of the next plan, and the set-point is what
/// makes a spindle with its lag do so. Without a speed channel the ratio is 1.
static void aim_speed(cam_plan_t *p, const cam_play_config_t *cfg, const cam_angle_t *angle,
                      int32_t z_nm, int32_t envelope, cam_motion_t *m)
{
    const cam_channel_t *ch = &cfg->table->speed;
    if (ch->knots == NULL) {
        return;
    }
    const uint32_t theta_q32 = cam_angle_of_pos(cam_angle_ahead(angle, cfg->ratio_q16));
    const cam_ratio_t ratio = cam_speed_ratio(ch, theta_q32 - phase_then_q32(m, cfg), z_nm);
    const int32_t from_q28 = p->ratio_q28;
    p->ratio_q28 = cam_speed_eased_q28(ratio.ratio_q28, envelope);
    m->spindle_mrpm = cam_speed_mrpm(&cfg->speed, from_q28, p->ratio_q28);
    m->alpha_q40 = cam_speed_alpha_q40(&cfg->speed, share(cfg, p->ratio_q28 - from_q28));
    m->alpha_u = cam_sat_i32(((int64_t)m->alpha_q40 * m->scale_q30) >> cfg->u.alpha_shift);
}

static void aim_swing(const cam_play_config_t *cfg, const cam_angle_t *angle, int32_t z_nm,
                      int32_t scale_q30, cam_motion_t *m)
{
    const cam_swing_config_t *swing = &cfg->swing;
    const int64_t pos_q32 = ahead_q32(angle, swing->ahead_q16, m->alpha_q40, swing->ahead2);
    cam_swing_aim_isr(&m->swing, cfg, cam_angle_of_pos(pos_q32) - phase_then_q32(m, cfg), z_nm,
                      scale_q30);
}

/// Phase and amplitude towards what the operator set, as far as their rates allow until the next
/// plan.
static void ramp(cam_plan_t *p, const cam_play_config_t *cfg, cam_motion_t *m)
{
    const int32_t left_q32 = cam_angle_diff_q32((uint32_t)cfg->phase_q32, (uint32_t)m->phase_q32);
    m->phase_step_q32 =
        cam_clamp_i32(share(cfg, left_q32), -cfg->phase_step_q32, cfg->phase_step_q32);
    if (m->phase_step_q32 == 0) {
        m->phase_q32 = cfg->phase_q32;
    }
    const int32_t most_q30 = cfg->amplitude_step_q30 * cfg->plan_ticks;
    p->amplitude_q30 += cam_clamp_i32(cfg->amplitude_q30 - p->amplitude_q30, -most_q30, most_q30);
}

/// Measured Z must lie on the table, a geared one moreover where its set-point was one lag ago.
static uint32_t look_at_z(const cam_play_config_t *cfg, int32_t z_nm, const cam_move_t *z)
{
    const int64_t due_q10 = z->pos_q10 - (((int64_t)z->vel_q10 * cfg->xz_lag_q16) >> 16);
    const int64_t off_nm = z_nm - (due_q10 >> 10);
    const bool is_off = !cfg->is_z_measured && cam_abs_i64(off_nm) > cfg->z_margin_nm;
    const bool is_out = z_nm < cfg->z_low_nm || z_nm > cfg->z_high_nm;
    return is_off || is_out ? CAM_FAULT_BIT(z_range) : 0u;
}

/// The state is that of the spindle itself, not of what is planned.
static cam_state_t state_at(const cam_plan_t *p, const cam_play_config_t *cfg, int64_t pos_q32)
{
    if (pos_q32 >= p->disengage_at_q32) {
        return pos_q32 < p->disengage_at_q32 + cfg->disengage_q32 ? cam_state_disengaging
                                                                  : cam_state_ready;
    }
    return pos_q32 < p->feed_at_q32 ? cam_state_engaging : cam_state_cutting;
}

/// @return [turn] the first whole turn that no axis was commanded to
static int64_t free_turn_q32(const cam_play_config_t *cfg, const cam_angle_t *angle)
{
    return cam_angle_next_turn(cam_angle_ahead(angle, cfg->commanded_q16));
}

/// The end of the feed, and behind it that of the cut, on a whole turn that no axis was commanded
/// to. A feed in motion falls over its ramp, a ring-helix goes on to the end of the next ring, a
/// feed that has not begun does not begin.
static void lay_end(cam_plan_t *p, const cam_play_config_t *cfg, const cam_angle_t *angle)
{
    const int64_t ramp_q32 = cfg->ramp_q32;
    int64_t turns_q32 = 0;
    int64_t end_q32 = free_turn_q32(cfg, angle);
    const int64_t fed_q32 = end_q32 - p->feed_at_q32;
    if (fed_q32 > 0 && !cfg->is_z_measured) {
        turns_q32 = cfg->rings.is_on     ? cam_feed_ring_end_q32(fed_q32)
                    : fed_q32 > ramp_q32 ? fed_q32 + ramp_q32
                                         : 2 * ramp_q32;
        end_q32 = p->feed_at_q32 + turns_q32;
    }
    if (end_q32 < p->disengage_at_q32) {
        p->feed_turns_q32 = turns_q32;
        p->disengage_at_q32 = end_q32;
    }
}

/// The cut is laid onto whole turns of the master; everything is at its start.
static void lay(cam_plan_t *p, const cam_play_config_t *cfg, const cam_tick_record_t *r,
                cam_motion_t *m)
{
    const int32_t actual_nm = r->in.actual_nm[hal_axis_z];
    p->engage_at_q32 = free_turn_q32(cfg, &r->angle);
    p->feed_at_q32 = p->engage_at_q32 + cfg->engage_q32;
    p->feed_turns_q32 = cfg->feed_q32;
    p->disengage_at_q32 = cfg->is_z_measured ? NEVER_Q32 : p->feed_at_q32 + cfg->feed_q32;
    p->amplitude_q30 = cfg->amplitude_q30;
    p->measured_nm = actual_nm;
    p->ratio_q28 = CAM_RATIO_ONE_Q28;
    m->phase_q32 = cfg->phase_q32;
    m->scale_q30 = 0;
    m->behind_q4 = 0;
    m->height_q32 = slice_q32(cfg, cfg->is_z_measured ? actual_nm : cfg->z_first_nm);
    m->is_stopping = false;
    m->is_playing = true;
}

/// All axes for the instant of the next plan.
static void aim_axes(cam_plan_t *p, const cam_play_config_t *cfg, const cam_tick_record_t *r,
                     cam_motion_t *m)
{
    const cam_angle_t *angle = &r->angle;
    const int64_t xz_q32 = ahead_q32(angle, cfg->xz_plan_q16, m->alpha_q40, cfg->xz_lag2);
    const int32_t z_nm = height_nm(p, cfg, r->in.actual_nm[hal_axis_z], xz_q32);
    const int64_t lag_q32 = ((int64_t)angle->speed_q32 * cfg->xz_lag_q16) >> 16;
    const int64_t u_q32 = cam_angle_ahead(angle, cfg->u_plan_q16);
    const int32_t u_envelope = envelope_q30(p, cfg, u_q32, 0);
    ramp(p, cfg, m);
    const int32_t scale_q30 = cam_mul_shift(u_envelope, p->amplitude_q30, 30);
    aim(&m->axis[hal_axis_z], cfg, (int64_t)z_nm * 1024);
    aim(&m->axis[hal_axis_x], cfg,
        profile_q10(cfg, z_nm, envelope_q30(p, cfg, xz_q32 - lag_q32, lag_q32)) + HALF_NM_Q10);
    aim_speed(p, cfg, angle, z_nm, u_envelope, m);
    aim_u(m, cfg, scale_q30, z_nm, u_height_nm(p, cfg, u_q32, z_nm, m->axis[hal_axis_z].vel_q10));
    if (cfg->swing.is_swung) {
        aim_swing(cfg, angle, z_nm, scale_q30, m);
    }
}

/// While the axes follow the table.
static void plan_cut(cam_plan_t *p, const cam_play_config_t *cfg, const cam_tick_record_t *r,
                     cam_motion_t *m)
{
    m->faults = look_at_z(cfg, r->in.actual_nm[hal_axis_z], &m->axis[hal_axis_z]);
    if (cfg->swing.is_swung) {
        m->faults |= cam_swing_look_isr(&m->swing, cfg, r->in.swing_q32);
    }
    if (m->is_stopping) {
        lay_end(p, cfg, &r->angle);
        m->is_stopping = false;
    }
    aim_axes(p, cfg, r, m);
    m->state = state_at(p, cfg, r->angle.pos_q32);
    if (m->state == cam_state_ready) { // scale 0: U has come to rest at 0
        m->axis[hal_axis_u] = (cam_move_t){0};
        m->u_target_q10 = cfg->u_retract_q10;
        m->is_playing = false;
    }
}

static bool is_at(const cam_move_t *m, int64_t place_q10)
{
    return m->pos_q10 == place_q10 && m->vel_q10 == 0;
}

/// One plan towards a place, or to rest, within limits per plan. @return true when it rests there
static bool move_to(cam_move_t *m, const cam_play_config_t *cfg, const cam_move_limits_t *limits,
                    int64_t place_q10)
{
    cam_move_t next = {.pos_q10 = m->pos_q10, .vel_q10 = m->vel_q10 * cfg->plan_ticks};
    const bool is_there = cam_move_to_isr(&next, limits, place_q10);
    aim(m, cfg, next.pos_q10);
    return is_there;
}

static bool brake(cam_move_t *m, const cam_play_config_t *cfg, const cam_move_limits_t *limits)
{
    cam_move_t next = {.pos_q10 = m->pos_q10, .vel_q10 = m->vel_q10 * cfg->plan_ticks};
    const bool is_at_rest = cam_move_stop_isr(&next, limits);
    aim(m, cfg, next.pos_q10);
    return is_at_rest;
}

/// Tool out of the work, feed axes at rest. @return true when all of them rest
static bool stay_out(const cam_play_config_t *cfg, cam_motion_t *m)
{
    m->u_target_q10 = cfg->u_retract_q10;
    const bool is_x_at_rest = brake(&m->axis[hal_axis_x], cfg, &cfg->approach[hal_axis_x]);
    const bool is_z_at_rest = brake(&m->axis[hal_axis_z], cfg, &cfg->approach[hal_axis_z]);
    if (cfg->swing.is_swung) {
        cam_swing_rest_isr(&m->swing, cfg, &cfg->swing.gentle);
    }
    return is_at(&m->axis[hal_axis_u], cfg->u_retract_q10) && is_x_at_rest && is_z_at_rest &&
           (!cfg->swing.is_swung || m->swing.is_there);
}

/// Z to the start of the cut, X standing, then X: the tool nears the work where it will cut.
/// @return true when both are there
static bool approach_xz(const cam_play_config_t *cfg, cam_motion_t *m)
{
    cam_move_t *x = &m->axis[hal_axis_x];
    const int64_t z_q10 = (int64_t)cfg->z_first_nm * 1024;
    if (is_at(&m->axis[hal_axis_z], z_q10)) {
        return move_to(x, cfg, &cfg->approach[hal_axis_x], profile_q10(cfg, cfg->z_first_nm, 0));
    }
    (void)move_to(&m->axis[hal_axis_z], cfg, &cfg->approach[hal_axis_z], z_q10);
    (void)brake(x, cfg, &cfg->approach[hal_axis_x]);
    return false;
}

/// X over a Z that others lead; its set-point is where it is. The tool nears the work when U is
/// ready. @return true when X is there
static bool approach_x(const cam_play_config_t *cfg, int32_t z_nm, bool is_u_there, cam_motion_t *m)
{
    cam_move_t *x = &m->axis[hal_axis_x];
    m->axis[hal_axis_z] = (cam_move_t){.pos_q10 = (int64_t)z_nm * 1024};
    if (!is_u_there) {
        (void)brake(x, cfg, &cfg->approach[hal_axis_x]);
        return false;
    }
    return move_to(x, cfg, &cfg->approach[hal_axis_x], profile_q10(cfg, z_nm, 0));
}

/// Axes to the start of the cut, which is laid when all are there. A tool that swings comes to rest
/// at 0 first.
static void plan_approach(cam_plan_t *p, const cam_play_config_t *cfg, const cam_tick_record_t *r,
                          cam_motion_t *m)
{
    if (cfg->swing.is_swung && !m->swing.is_there) {
        (void)stay_out(cfg, m);
        return;
    }
    m->u_target_q10 = 0;
    const bool is_u_there = is_at(&m->axis[hal_axis_u], 0);
    const bool is_xz_there = cfg->is_z_measured
                                 ? approach_x(cfg, r->in.actual_nm[hal_axis_z], is_u_there, m)
                                 : approach_xz(cfg, m);
    if (is_u_there && is_xz_there) {
        lay(p, cfg, r, m);
        aim_axes(p, cfg, r, m);
    }
}

/// A fault: the guard retracts U, X moves off from where it was led in that tick, Z brakes to rest.
static void move_off(const cam_play_config_t *cfg, cam_motion_t *m)
{
    const int64_t off_q10 = m->x_left_q10 + (int64_t)cfg->x_clearance_nm * 1024;
    if (cfg->swing.is_swung) {
        cam_swing_rest_isr(&m->swing, cfg, &cfg->swing.full);
    }
    const bool is_x_off = move_to(&m->axis[hal_axis_x], cfg, &cfg->leave[hal_axis_x], off_q10);
    const bool is_z_at_rest = brake(&m->axis[hal_axis_z], cfg, &cfg->leave[hal_axis_z]);
    m->is_clear = is_x_off && is_z_at_rest && (!cfg->swing.is_swung || m->swing.is_there);
}

/// Homing ends when the angle is known, the spindle turns and the tool is out of the work.
static void plan_homing(const cam_play_config_t *cfg, const cam_angle_t *angle, cam_motion_t *m)
{
    const bool is_out = stay_out(cfg, m);
    if (is_out && angle->is_synced && angle->speed_q32 >= cfg->turning_q32) {
        m->state = cam_state_ready;
    }
}

/// The tool is out of the work, or moves from or to it.
static void plan_rest(cam_plan_t *p, const cam_play_config_t *cfg, const cam_tick_record_t *r,
                      cam_motion_t *m)
{
    const bool is_idle = m->state == cam_state_off || m->state == cam_state_fault;
    m->spindle_mrpm = is_idle ? 0 : cfg->spindle_mrpm;
    m->alpha_q40 = 0;
    m->alpha_u = 0;
    m->faults = 0;
    if (m->state == cam_state_fault) {
        move_off(cfg, m);
        return;
    }
    m->is_clear = false;
    if (m->state == cam_state_off) {
        cam_swing_follow_isr(&m->swing, r->in.swing_q32);
    } else if (m->state == cam_state_engaging) {
        plan_approach(p, cfg, r, m);
    } else if (m->state == cam_state_homing) {
        plan_homing(cfg, &r->angle, m);
    } else {
        (void)stay_out(cfg, m);
    }
}

void cam_plan_isr(cam_plan_t *p, const cam_play_config_t *cfg, const cam_tick_record_t *r,
                  cam_motion_t *m)
{
    if (m->is_playing) {
        plan_cut(p, cfg, r, m);
    } else {
        plan_rest(p, cfg, r, m);
    }
}
