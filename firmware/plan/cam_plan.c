// SPDX-License-Identifier: Apache-2.0
#include "cam_plan_inner.h"
#include "cam_fix.h"    // cam_angle_of_pos, cam_clamp_i32
#include "cam_motion.h" // cam_envelope_step_q30
#include "cam_eval.h"   // cam_eval_height, cam_feed_profile_at

/// [nm / 1024] half a nanometre: the tick truncates X to nanometres, so this rounds to nearest.
#define HALF_NM_Q10 512

/// [1] in the unit of envelopes.
#define ONE_Q30 (INT32_C(1) << 30)

/// [slices] half of one per tick; sixteen times as much still fits 32 bits.
#define MOST_STEP_Q28 ((INT32_C(1) << 27) - 1)

/// Disengage position of a cut that only stop ends.
#define NEVER_Q32 (INT64_MAX / 2)

/// @return [turn] future master position, including the acceleration of the spindle
static int64_t ahead_q32(const cam_angle_t *angle, int32_t ticks_q16, int32_t alpha_q40,
                         int32_t ticks2)
{
    return cam_wrap_add_i64(cam_angle_ahead(angle, ticks_q16), ((int64_t)alpha_q40 * ticks2) >> 8);
}

/// @param lag_q32  [turn] travelled during the lag of the drive
/// @return         [1 / 2^30] 0 outside the work, 2^30 at full depth and amplitude
static int32_t envelope_q30(const cam_plan_t *p, const cam_play_config_t *cfg, int64_t pos_q32,
                            int64_t lag_q32)
{
    const int32_t risen_q30 = cam_envelope_step_q30(cam_wrap_sub_i64(pos_q32, p->engage_at_q32),
                                                    lag_q32, cfg->engage_q32, cfg->per_engage_q31);
    const int32_t fallen_q30 =
        cam_envelope_step_q30(cam_wrap_sub_i64(pos_q32, p->disengage_at_q32), lag_q32,
                              cfg->disengage_q32, cfg->per_disengage_q31);
    return cam_mul_shift(risen_q30, ONE_Q30 - fallen_q30, 30);
}

/// @return slice of a channel: pattern of the current lobe, or the slices around the height
static inline cam_height_t slice_of(const cam_shaft_t *s, const cam_table_t *t,
                                    const cam_channel_t *ch, int32_t z_nm)
{
    return t->n_lobes > 0u ? cam_lobes_slice(ch->n_slices, t->lobes[s->i_lobe].pattern)
                           : cam_eval_height(ch, z_nm);
}

/// @return [nm / 1024] a height of the part in port coordinates of Z, MATHS.md (170)
static int64_t by_port_q10(const cam_play_config_t *cfg, int32_t z_nm)
{
    return ((int64_t)z_nm + cfg->z_origin_nm) * 1024;
}

/// @return [nm] Z at the next plan, on a plain helix; a measured Z repeats its last travel per plan
static int32_t height_nm(cam_plan_t *p, const cam_play_config_t *cfg, int32_t actual_nm,
                         int64_t pos_q32)
{
    const int32_t moved_nm = actual_nm - p->measured_nm;
    p->measured_nm = actual_nm;
    return cfg->is_z_measured
               ? cam_sat_i32((int64_t)actual_nm - cfg->z_origin_nm + moved_nm)
               : cam_sat_add(cfg->z_first_nm,
                             cam_feed_motion_fed_nm_isr(&p->feed_motion, cfg, pos_q32));
}

/// @return [slices] of U at a height
static int64_t slice_q32(const cam_play_config_t *cfg, int32_t z_nm)
{
    const cam_height_t at = cam_eval_height(&cfg->table->u, z_nm);
    const int64_t found_q32 = (int64_t)((uint64_t)at.i << 32 | (uint32_t)at.w_q31 << 1);
    return cam_clamp_i64(found_q32, 0, cfg->height_max_q32);
}

/// Plan U's height on the table. The increment saturates at half a slice per tick, faster than any
/// feed. It is rounded towards 0, so the remainder, which is added at once, points towards the
/// target: U never leaves the table.
static void plan_height(cam_motion_t *m, const cam_play_config_t *cfg, int64_t target_q32)
{
    const int32_t left_q28 = cam_sat_i32(cam_wrap_sub_i64(target_q32, m->height_q32) >> 4);
    const int64_t step_q58 = (int64_t)left_q28 * cfg->per_plan_q30;
    const int32_t exact_q28 = (int32_t)((step_q58 < 0 ? step_q58 + ONE_Q30 - 1 : step_q58) >> 30);
    const int32_t step_q28 = cam_clamp_i32(exact_q28, -MOST_STEP_Q28, MOST_STEP_Q28);
    m->height_step_q32 = step_q28 * 16;
    m->height_q32 = target_q32 - (int64_t)m->height_step_q32 * cfg->plan_ticks;
}

/// @return [nm] actual Z at the instant at which U reaches its command of the next plan, from the
/// feed. Z's set-point minus speed times lag would be the same, but would amplify the noise of the
/// observed speed, which shows in U where the table is steep over the height.
static int32_t u_height_nm(const cam_plan_t *p, const cam_play_config_t *cfg, int64_t pos_q32,
                           int32_t z_nm, int32_t z_vel_q10)
{
    return cfg->is_z_measured
               ? cam_sat_add(z_nm, (int32_t)(((int64_t)z_vel_q10 * cfg->lead_q16) >> 26))
               : cam_sat_add(cfg->z_first_nm,
                             cam_feed_motion_fed_nm_isr(&p->feed_motion, cfg, pos_q32));
}

/// Plan U's amplitude, and how far Z's set-point is ahead of its height.
static void plan_u(cam_motion_t *m, const cam_play_config_t *cfg, int32_t scale_q30,
                   int32_t ahead_nm)
{
    m->z_ahead_nm = cam_sat_add(cfg->z_origin_nm, ahead_nm);
    m->scale_step_q30 = cam_plan_move_share(cfg, cam_sat_sub(scale_q30, m->scale_q30));
    m->scale_q30 = cam_sat_i32(scale_q30 - (int64_t)m->scale_step_q30 * cfg->plan_ticks);
}

/// Height at which X is evaluated, how far Z's set-point is ahead of U's height, and shares of the
/// lobe.
typedef struct {
    int32_t z_nm, ahead_nm;
    cam_share_t share;
} height_t;

/// Plan Z and U's height for a skirt. With a feed profile Z deviates from the helix; U is so close
/// to Z that the slope of the profile at Z holds for U as well. With stations X and U stay on the
/// helix.
static height_t plan_skirt(const cam_plan_t *p, const cam_play_config_t *cfg, cam_motion_t *m,
                           int32_t helix_nm, int64_t u_q32)
{
    const bool has_profile = cfg->table->way.knots != NULL && !cfg->is_z_measured;
    const cam_feed_profile_t plain = {.z_nm = helix_nm};
    const cam_feed_profile_t profile =
        has_profile ? cam_feed_profile_at(cfg->table, helix_nm) : plain;
    cam_plan_move_line_isr(&m->axis[hal_axis_z], cfg, by_port_q10(cfg, profile.z_nm));
    const int32_t u_nm = u_height_nm(p, cfg, u_q32, helix_nm, m->axis[hal_axis_z].vel_q10);
    height_t at = {helix_nm, cam_sat_sub(helix_nm, u_nm), {ONE_Q30, ONE_Q30}};
    int32_t u_z_nm = u_nm;
    if (has_profile) {
        at.ahead_nm = cam_sat_i32(((int64_t)at.ahead_nm * profile.slope_q16) >> 16);
    }
    if (has_profile && !cfg->table->has_stations) {
        at.z_nm = profile.z_nm;
        u_z_nm = cam_sat_sub(profile.z_nm, at.ahead_nm);
    }
    plan_height(m, cfg, slice_q32(cfg, u_z_nm));
    return at;
}

/// Plan Z and U's pattern for a shaft of lobes. With stations, the helix selects lobes and X, and Z
/// follows the feed profile; the lift changes only while X is off, so U's lead over X is harmless.
static height_t plan_shaft(cam_plan_t *p, const cam_play_config_t *cfg, cam_motion_t *m,
                           int32_t helix_nm, int64_t u_q32)
{
    const cam_table_t *t = cfg->table;
    cam_axis_motion_t *z = &m->axis[hal_axis_z];
    int32_t ahead_nm = 0;
    int32_t lobe_z_nm = helix_nm;
    if (t->has_stations) {
        cam_plan_move_line_isr(z, cfg, by_port_q10(cfg, cam_feed_profile_at(t, helix_nm).z_nm));
    } else {
        cam_plan_move_line_isr(z, cfg, by_port_q10(cfg, helix_nm));
        const int32_t u_nm = u_height_nm(p, cfg, u_q32, helix_nm, z->vel_q10);
        ahead_nm = cam_sat_sub(helix_nm, u_nm);
        lobe_z_nm = cfg->is_z_measured ? cam_shaft_smooth_isr(&p->shaft, u_nm) : u_nm;
    }
    return (height_t){helix_nm, ahead_nm, cam_shaft_plan_isr(&p->shaft, t, lobe_z_nm, m)};
}

/// @return [turn / 2^32] phase at the next plan
static uint32_t phase_then_q32(const cam_motion_t *m, const cam_play_config_t *cfg)
{
    return (uint32_t)m->phase_q32 + (uint32_t)m->phase_step_q32 * (uint32_t)cfg->plan_ticks;
}

/// Plan the spindle: the speed ratio changes linearly until the next plan, and the set-point
/// compensates for the spindle's lag. Without a speed channel the ratio is 1.
static void plan_speed(cam_plan_t *p, const cam_play_config_t *cfg, const cam_angle_t *angle,
                       int32_t z_nm, int32_t envelope, cam_motion_t *m)
{
    const cam_channel_t *ch = &cfg->table->speed;
    if (ch->knots == NULL) {
        m->spindle_mrpm = cam_mul_shift(cfg->spindle_mrpm, p->spindle_rate_q30, 30);
        return;
    }
    const cam_speed_config_t speed = cam_speed_overridden(&cfg->speed, p->spindle_rate_q30);
    const uint32_t theta_q32 = cam_angle_of_pos(cam_angle_ahead(angle, cfg->ratio_q16));
    const int32_t ratio_q28 = cam_speed_ratio_q28_at(ch, theta_q32 - phase_then_q32(m, cfg),
                                                     slice_of(&p->shaft, cfg->table, ch, z_nm));
    const int32_t from_q28 = p->ratio_q28;
    const int32_t held_q28 = // wider than any checked table
        cam_clamp_i32(ratio_q28, CAM_RATIO_ONE_Q28 / 32, CAM_RATIO_ONE_Q28 * 5);
    p->ratio_q28 = cam_speed_eased_q28(held_q28, envelope);
    m->spindle_mrpm = cam_speed_mrpm(&speed, from_q28, p->ratio_q28);
    m->alpha_q40 = cam_speed_alpha_q40(&speed, cam_plan_move_share(cfg, p->ratio_q28 - from_q28));
    m->alpha_u = cam_sat_i32(((int64_t)m->alpha_q40 * m->scale_q30) >> cfg->u.alpha_shift);
}

/// Move a value towards another by at most a step, without overshoot.
/// @return the new value
/*@ requires most >= 0;
    assigns \result \from value, to, most;
    ensures between: \min(value, to) <= \result <= \max(value, to);
    ensures step: \abs(\result - value) <= most;
    ensures there: \abs(to - value) <= most ==> \result == to;
*/
static int32_t ramped(int32_t value, int32_t to, int32_t most)
{
    if (value < to) {
        const int32_t more = cam_sat_add(value, most);
        return more < to ? more : to;
    }
    const int32_t less = cam_sat_add(value, -most);
    return less > to ? less : to;
}

/// Ramp phase, amplitude, trim and spindle override towards the operator's values.
static void ramp(cam_plan_t *p, const cam_play_config_t *cfg, cam_motion_t *m)
{
    const uint32_t to_q32 = (uint32_t)cfg->phase_q32 + p->shaft.phase_q32;
    const int32_t left_q32 = cam_wrap_diff(to_q32, (uint32_t)m->phase_q32);
    m->phase_step_q32 = cam_clamp_i32(cam_plan_move_share(cfg, left_q32), -cfg->phase_step_q32,
                                      cfg->phase_step_q32);
    if (m->phase_step_q32 == 0) {
        m->phase_q32 = (int32_t)to_q32;
    }
    const int32_t most_q30 = cfg->amplitude_step_q30 * cfg->plan_ticks;
    p->amplitude_q30 = ramped(p->amplitude_q30, cfg->amplitude_q30, most_q30);
    p->x_trim_q4 = ramped(p->x_trim_q4, cfg->x_trim_q4, cfg->x_trim_step_q4);
    p->spindle_rate_q30 = ramped(p->spindle_rate_q30, cfg->spindle_rate_q30, cfg->spindle_step_q30);
}

/// Check the measured Z: it must be on the table. A geared Z must be at its set-point of one lag
/// ago; a measured Z must be near its position of the last plan, or U and X could not follow it.
/// @param last_nm  [nm] measured Z of the last plan
/// @return         fault z_range or none
static uint32_t check_z(const cam_play_config_t *cfg, int32_t z_nm, int32_t last_nm,
                        const cam_axis_motion_t *z)
{
    const int64_t behind_q10 = ((int64_t)z->vel_q10 * cfg->xz_lag_q16) >> 16;
    const int64_t due_q10 = cam_wrap_sub_i64(z->pos_q10, behind_q10);
    const int64_t due_nm = cfg->is_z_measured ? last_nm : due_q10 >> 10;
    const bool is_off = cam_abs_i64(z_nm - due_nm) > cfg->z_margin_nm;
    const bool is_out = z_nm < cfg->z_low_nm || z_nm > cfg->z_high_nm;
    return is_off || is_out ? CAM_FAULT_BIT(z_range) : 0u;
}

/// The state follows the spindle itself, not the planned position. Reverse rotation never restarts
/// engaging or cutting: the state stays until the fault `reverse`. A rehearsal ends when the
/// amplitude has fallen, and the cut follows unless it was stopped.
static cam_state_t state_at(const cam_plan_t *p, const cam_play_config_t *cfg, int64_t pos_q32,
                            cam_state_t was)
{
    const bool is_out = pos_q32 >= cam_wrap_add_i64(p->disengage_at_q32, cfg->disengage_q32);
    if (p->is_rehearsal) {
        const cam_state_t next = p->is_stopped ? cam_state_ready : cam_state_engaging;
        return is_out ? next : cam_state_rehearsing;
    }
    if (pos_q32 >= p->disengage_at_q32 || was == cam_state_disengaging) {
        return is_out ? cam_state_ready : cam_state_disengaging;
    }
    const bool is_resting = p->feed_motion.is_held && pos_q32 >= p->feed_motion.end_q32;
    const cam_state_t fed = is_resting ? cam_state_holding : cam_state_cutting;
    const bool is_engaging = was == cam_state_engaging && pos_q32 < p->feed_at_q32;
    return is_engaging ? cam_state_engaging : fed;
}

/// @return [turn] first whole turn beyond everything commanded so far
static int64_t next_turn_q32(const cam_play_config_t *cfg, const cam_angle_t *angle)
{
    return cam_angle_next_turn(cam_angle_ahead(angle, cfg->commanded_q16));
}

/// Schedule the end of the feed, and then of the cut, at a whole turn that is not yet commanded.
static void schedule_end(cam_plan_t *p, const cam_play_config_t *cfg, const cam_angle_t *angle)
{
    const int64_t next_q32 = next_turn_q32(cfg, angle);
    const bool has_feed = !cfg->is_z_measured && !p->is_rehearsal;
    const int64_t end_q32 =
        has_feed ? cam_feed_motion_stop_isr(&p->feed_motion, cfg, next_q32) : next_q32;
    p->disengage_at_q32 = end_q32 < p->disengage_at_q32 ? end_q32 : p->disengage_at_q32;
    p->is_stopped = true;
}

/// @return [turn] where the cut ends if the feed continues as planned
static int64_t end_of_feed_q32(const cam_plan_t *p)
{
    return p->feed_motion.is_held ? NEVER_Q32 : p->feed_motion.end_q32;
}

/// Follow override and hold of the feed, unless the cut is stopped.
static void follow_override(cam_plan_t *p, const cam_play_config_t *cfg, const cam_angle_t *angle)
{
    if (cfg->feed_rate_q30 != p->feed_motion.requested_q30 && !p->is_rehearsal && !p->is_stopped &&
        !cfg->is_z_measured) {
        cam_feed_motion_request_isr(&p->feed_motion, cfg, angle->pos_q32,
                                    next_turn_q32(cfg, angle));
        p->disengage_at_q32 = end_of_feed_q32(p);
    }
}

/// Schedule the cut at whole turns of the master, and initialise everything that changes in it. All
/// axes rest until the next plan, and the cut begins after that.
static void begin_cut(cam_plan_t *p, const cam_play_config_t *cfg, const cam_tick_record_t *r,
                      cam_motion_t *m)
{
    const int32_t actual_nm = r->in.actual_nm[hal_axis_z];
    const int32_t part_nm = cam_sat_sub(actual_nm, cfg->z_origin_nm);
    const int32_t z_nm = cfg->is_z_measured ? part_nm : cfg->z_first_nm;
    p->engage_at_q32 = cam_angle_next_turn(
        cam_angle_ahead(&r->angle, cfg->commanded_q16 + cfg->plan_ticks * 65536));
    const int64_t risen_q32 = cam_wrap_add_i64(p->engage_at_q32, cfg->engage_q32);
    p->is_stopped = false;
    p->is_rehearsal = m->state == cam_state_rehearsing; // at the first height, without feed
    p->feed_at_q32 = p->is_rehearsal ? NEVER_Q32 : cam_wrap_add_i64(risen_q32, cfg->settle_q32);
    cam_feed_motion_begin_isr(&p->feed_motion, cfg, p->feed_at_q32);
    const int64_t fed_q32 = cfg->is_z_measured ? NEVER_Q32 : end_of_feed_q32(p);
    p->disengage_at_q32 =
        p->is_rehearsal ? cam_wrap_add_i64(risen_q32, cfg->rehearse_q32) : fed_q32;
    p->amplitude_q30 = cfg->amplitude_q30;
    p->x_trim_q4 = cfg->x_trim_q4;
    p->spindle_rate_q30 = cfg->spindle_rate_q30;
    p->measured_nm = actual_nm;
    p->ratio_q28 = CAM_RATIO_ONE_Q28;
    m->phase_q32 = cfg->phase_q32;
    m->scale_q30 = 0;
    m->z_ahead_nm = cfg->z_origin_nm;
    m->height_q32 = slice_q32(cfg, z_nm);
    m->is_stopping = false;
    m->is_playing = true;
    cam_shaft_begin_isr(&p->shaft, cfg->table, z_nm, m);
}

/// Plan all axes for the instant of the next plan.
static void plan_axes(cam_plan_t *p, const cam_play_config_t *cfg, const cam_tick_record_t *r,
                      cam_motion_t *m)
{
    const cam_angle_t *angle = &r->angle;
    const int64_t xz_q32 = ahead_q32(angle, cfg->xz_plan_q16, m->alpha_q40, cfg->xz_lag2);
    const int32_t helix_nm = height_nm(p, cfg, r->in.actual_nm[hal_axis_z], xz_q32);
    const int64_t lag_q32 = ((int64_t)angle->speed_q32 * cfg->xz_lag_q16) >> 16;
    const int64_t u_q32 = cam_angle_ahead(angle, cfg->u_plan_q16);
    const int32_t u_envelope = envelope_q30(p, cfg, u_q32, 0);
    ramp(p, cfg, m);
    const height_t at = cfg->table->n_lobes == 0u ? plan_skirt(p, cfg, m, helix_nm, u_q32)
                                                  : plan_shaft(p, cfg, m, helix_nm, u_q32);
    const int32_t z_nm = at.z_nm;
    const int32_t scale_q30 =
        cam_mul_shift(cam_mul_shift(u_envelope, at.share.lift_q30, 30), p->amplitude_q30, 30);
    // In a rehearsal X stays off the work.
    const int32_t x_envelope =
        p->is_rehearsal ? 0 : envelope_q30(p, cfg, cam_wrap_sub_i64(xz_q32, lag_q32), lag_q32);
    const int64_t away_q10 = p->is_rehearsal ? cfg->rehearse_x_q10 : 0;
    const int64_t x_q10 = cam_plan_move_profile_q10(cfg, z_nm, x_envelope, p->x_trim_q4);
    cam_plan_move_line_isr(&m->axis[hal_axis_x], cfg, x_q10 + HALF_NM_Q10 + away_q10);
    plan_speed(p, cfg, angle, z_nm, cam_mul_shift(u_envelope, at.share.ratio_q30, 30), m);
    plan_u(m, cfg, scale_q30, at.ahead_nm);
    if (cfg->swing.is_swung && !p->is_rehearsal) {
        const cam_swing_config_t *swing = &cfg->swing;
        const int64_t swing_q32 = ahead_q32(angle, swing->ahead_q16, m->alpha_q40, swing->ahead2);
        cam_swing_plan_isr(&m->swing, cfg, cam_angle_of_pos(swing_q32) - phase_then_q32(m, cfg),
                           slice_of(&p->shaft, cfg->table, &cfg->table->angle, z_nm), scale_q30);
    }
}

/// One plan while the axes follow the table.
static void plan_cut(cam_plan_t *p, const cam_play_config_t *cfg, const cam_tick_record_t *r,
                     cam_motion_t *m)
{
    m->faults = check_z(cfg, r->in.actual_nm[hal_axis_z], p->measured_nm, &m->axis[hal_axis_z]);
    if (cfg->swing.is_swung) {
        m->faults |= cam_swing_check_isr(&m->swing, cfg, r->in.swing_q32);
    }
    if (m->is_stopping) {
        schedule_end(p, cfg, &r->angle);
        m->is_stopping = false;
    } else {
        follow_override(p, cfg, &r->angle);
    }
    if ((m->faults & CAM_FAULT_BIT(z_range)) != 0u) {
        return; // The guard takes over in the next tick; until then nothing follows a wrong height.
    }
    plan_axes(p, cfg, r, m);
    m->state = state_at(p, cfg, r->angle.pos_q32, m->state);
    const bool is_rehearsed = p->is_rehearsal && m->state == cam_state_engaging;
    if (m->state == cam_state_ready || is_rehearsed) { // scale 0: U rests at 0
        m->axis[hal_axis_u] = (cam_axis_motion_t){0};
        cam_jerk_filter_begin_isr(&m->filter[hal_axis_u], &m->axis[hal_axis_u],
                                  cfg->approach[hal_axis_u].log2_window);
        m->u_target_q10 = m->state == cam_state_ready ? cfg->u_retract_q10 : 0;
        m->is_playing = false;
    }
}

void cam_plan_isr(cam_plan_t *p, const cam_play_config_t *cfg, const cam_tick_record_t *r,
                  cam_motion_t *m)
{
    if (m->is_playing) {
        m->is_filtering = false;
        plan_cut(p, cfg, r, m);
        return;
    }
    const bool is_there = cam_positioning_isr(cfg, r, m);
    if (cam_steady_isr(&p->steady, cfg, m->state, r->angle.pos_q32, is_there)) {
        begin_cut(p, cfg, r, m);
    }
}
