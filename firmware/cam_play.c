// SPDX-License-Identifier: Apache-2.0
#include "cam/cam_play.h"
#include "cam/cam_angle.h" // cam_angle_next_turn
#include "cam/cam_eval.h"  // cam_eval_surface
#include "cam/cam_fix.h"   // cam_clamp_i32

/// Disengage position while nobody asked for one.
#define NEVER_Q32 (INT64_MAX / 2)

int32_t cam_play_smooth_q30(int32_t s_q31)
{
    const int32_t s2_q31 = cam_mul_shift(s_q31, s_q31, 31);
    const int32_t s3_q31 = cam_mul_shift(s2_q31, s_q31, 31);
    // Up to 10, but the product with s^3 stays below 1: 62 bits.
    const int64_t inner_q31 = 10 * (INT64_C(1) << 31) - 15 * (int64_t)s_q31 + 6 * (int64_t)s2_q31;
    const int64_t y_q30 = (s3_q31 * inner_q31 + (INT64_C(1) << 31)) >> 32;
    return (int32_t)cam_clamp_i64(y_q30, 0, INT32_C(1) << 30); // rounding near 1 may pass it
}

/// @return [1 / 2^30] smooth step over `length` from position `at`
static int32_t rise_q30(int64_t pos_q32, int64_t at_q32, int64_t length_q32,
                        uint32_t per_length_q31)
{
    const int64_t done_q32 = pos_q32 - at_q32;
    if (done_q32 <= 0 || done_q32 >= length_q32) { // most of a cut lies outside of both steps
        return done_q32 <= 0 ? 0 : INT32_C(1) << 30;
    }
    const int64_t done_q24 = done_q32 >> 8;
    const int64_t s_q31 = (done_q24 * per_length_q31) >> 24;
    return cam_play_smooth_q30((int32_t)cam_clamp_i64(s_q31, 0, INT32_MAX));
}

/// @return [1 / 2^30] 0 out of the work, 2^30 at full depth and amplitude
static int32_t envelope_q30(const cam_play_t *p, const cam_play_config_t *cfg, int64_t pos_q32)
{
    const int32_t up = rise_q30(pos_q32, p->engage_at_q32, cfg->engage_q32, cfg->per_engage_q31);
    const int32_t down =
        rise_q30(pos_q32, p->disengage_at_q32, cfg->disengage_q32, cfg->per_disengage_q31);
    return cam_mul_shift(up, (INT32_C(1) << 30) - down, 30);
}

/// @return [turn] master position after some ticks at this speed
static int64_t ahead(const cam_angle_t *angle, int32_t ticks_q16)
{
    return angle->pos_q32 + (((int64_t)angle->speed_q32 * ticks_q16) >> 16);
}

/// @return [turn] the furthest position that any axis is told of before the next plan
static int64_t furthest_q32(const cam_play_config_t *cfg, const cam_angle_t *angle)
{
    const int32_t most_q16 =
        cfg->u_plan_q16 > cfg->xz_plan_q16 ? cfg->u_plan_q16 : cfg->xz_plan_q16;
    return ahead(angle, most_q16 + cam_play_tasks * 65536);
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

static int64_t profile_q10(const cam_play_config_t *cfg, int32_t z_nm)
{
    const cam_channel_t *x = &cfg->table->x;
    return (((int64_t)cam_eval_profile(x, z_nm).y * 1024) >> x->frac_bits) +
           (int64_t)x->offset_nm * 1024;
}

/// U with its velocity and acceleration: derivatives per knot times knots per tick. The slow change
/// of envelope, amplitude and height adds nothing worth naming to them (a skirt: 1e-6 of the
/// speed). @return [nm / 64] U
CAM_STAGE static int32_t surface(const cam_play_t *p, const cam_play_config_t *cfg,
                                 int32_t speed_q32, uint32_t theta_q32, int32_t z_nm, cam_move_t *u)
{
    const cam_u_scale_t *by = &cfg->u;
    const cam_channel_t *ch = &cfg->table->u;
    const cam_fine_t fine = cam_eval_at(ch, theta_q32, cam_eval_height(ch, z_nm));
    const int32_t y = (fine.y >> by->y_down) + by->offset;
    const int32_t u_q6 = cam_shift_right((int64_t)y * p->scale_q30, by->y_shift);
    const int32_t max_q32 = by->speed_max_q32;
    const int32_t speed = cam_clamp_i32(speed_q32, -max_q32, max_q32) * (1 << by->speed_shift);
    const int32_t rate = cam_mulhi(speed, p->scale_q30);
    const int32_t rate2 = cam_mulhi(cam_mulhi(speed, speed), p->scale_q30);
    const int64_t velocity = (int64_t)(fine.d1 >> by->v_down) * rate;
    const int64_t acceleration =
        (int64_t)(fine.d2 >> by->a_down) * rate2 + (int64_t)fine.d1 * p->alpha_u;
    *u = (cam_move_t){
        .pos_q10 = (int64_t)u_q6 * 16,
        .vel_q10 = cam_shift_right(velocity, by->v_shift),
        .acc_q10 = cam_shift_right(acceleration, by->a_shift),
    };
    return u_q6;
}

/// Phase and amplitude on their way to what the operator set, as far as four ticks go.
static void ramp(cam_play_t *p, const cam_play_config_t *cfg)
{
    const int32_t most_q32 = cfg->phase_step_q32;
    const int32_t left_q32 = cam_angle_diff_q32((uint32_t)cfg->phase_q32, (uint32_t)p->phase_q32);
    p->phase_way_q32 = cam_clamp_i32(left_q32 / cam_play_tasks, -most_q32, most_q32);
    if (p->phase_way_q32 == 0) {
        p->phase_q32 = cfg->phase_q32;
    }
    const int32_t most_q30 = cfg->amplitude_step_q30 * cam_play_tasks;
    p->amplitude_q30 += cam_clamp_i32(cfg->amplitude_q30 - p->amplitude_q30, -most_q30, most_q30);
}

static cam_state_t state_at(const cam_play_t *p, const cam_play_config_t *cfg, int64_t pos_q32)
{
    if (pos_q32 >= p->disengage_at_q32) {
        return pos_q32 < p->disengage_at_q32 + cfg->disengage_q32 ? cam_state_disengaging
                                                                  : cam_state_ready;
    }
    return pos_q32 < p->feed_at_q32 ? cam_state_engaging : cam_state_cutting;
}

/// Task 0: where the axes shall be at the end of the next four ticks.
CAM_STAGE static void plan(cam_play_t *p, const cam_play_config_t *cfg, const cam_sense_t *in,
                           const cam_angle_t *angle)
{
    const int64_t spindle_lag_q32 = ((int64_t)p->speed.alpha_q40 * cfg->xz_lag2) >> 8;
    const int64_t xz_pos_q32 = ahead(angle, cfg->xz_plan_q16) + spindle_lag_q32;
    const int32_t z_nm = in->actual_nm[hal_axis_z];
    const int32_t going_on_nm = cam_sat_i32(2 * (int64_t)z_nm - p->measured_z_nm);
    p->plan_z_nm = cfg->is_z_measured ? going_on_nm : height_nm(p, cfg, xz_pos_q32);
    p->measured_z_nm = z_nm;
    p->x_envelope_q30 = envelope_q30(p, cfg, xz_pos_q32);
    p->u_envelope_q30 = envelope_q30(p, cfg, ahead(angle, cfg->u_plan_q16));
    p->state = state_at(p, cfg, angle->pos_q32);
}

/// Equal ways to a target in four ticks; what does not divide is gone at once.
static void aim(cam_move_t *m, int64_t target_q10)
{
    const int64_t left_q10 = target_q10 - m->pos_q10;
    m->vel_q10 = (int32_t)(left_q10 >> 2);
    m->acc_q10 = 0;
    m->pos_q10 += left_q10 & (cam_play_tasks - 1);
}

/// Task 1: X at the planned height, and the ways of all.
CAM_STAGE static void aim_all(cam_play_t *p, const cam_play_config_t *cfg, cam_move_t *axis)
{
    const int32_t out_q30 = (INT32_C(1) << 30) - p->x_envelope_q30;
    const int64_t clear_q10 = ((cfg->x_clearance_q10 >> 10) * out_q30) >> 20;
    aim(&axis[hal_axis_x], profile_q10(cfg, p->plan_z_nm) + clear_q10);
    aim(&axis[hal_axis_z], (int64_t)p->plan_z_nm * 1024);
    ramp(p, cfg);
    const int32_t scale_q30 = cam_mul_shift(p->u_envelope_q30, p->amplitude_q30, 30);
    const int32_t left_q30 = scale_q30 - p->scale_q30;
    p->scale_way_q30 = left_q30 >> 2;
    p->scale_q30 += left_q30 & (cam_play_tasks - 1);
    p->z_behind_nm = (int32_t)(((int64_t)axis[hal_axis_z].vel_q10 * cfg->u_behind_q16) >> 26);
}

/// Task 2: the speed ratio at the middle of the time for which it will be used; a table without a
/// speed channel costs this one question.
CAM_STAGE static void read_ratio(cam_play_t *p, const cam_play_config_t *cfg, int32_t speed_q32,
                                 uint32_t theta_q32)
{
    const cam_channel_t *speed = &cfg->table->speed;
    if (speed->knots != NULL) {
        const uint32_t later_q32 = (uint32_t)(speed_q32 >> 1) * 5u;
        p->ratio = cam_speed_ratio(speed, theta_q32 + later_q32, p->plan_z_nm);
    }
}

/// Measured Z must lie on the table, a geared one moreover where its set-point was one lag ago.
static uint32_t range_fault(const cam_play_config_t *cfg, const cam_sense_t *in,
                            const cam_move_t *z)
{
    const int32_t z_nm = in->actual_nm[hal_axis_z];
    const int64_t due_q10 = z->pos_q10 - (((int64_t)z->vel_q10 * cfg->xz_lag_q16) >> 16);
    const int64_t off_nm = z_nm - (due_q10 >> 10);
    const bool is_off = !cfg->is_z_measured && cam_abs_i64(off_nm) > cfg->z_margin_nm;
    const bool is_out = z_nm < cfg->z_low_nm || z_nm > cfg->z_high_nm;
    return is_off || is_out ? CAM_FAULT_BIT(z_range) : 0u;
}

/// Task 3: the spindle from its own angle. @return faults of Z
CAM_STAGE static uint32_t modulate(cam_play_t *p, const cam_play_config_t *cfg,
                                   const cam_sense_t *in, const cam_move_t *axis)
{
    if (cfg->table->speed.knots != NULL) {
        p->speed = cam_speed_law(&cfg->speed, p->ratio, p->u_envelope_q30);
        p->alpha_u =
            cam_sat_i32(((int64_t)p->speed.alpha_q40 * p->scale_q30) >> cfg->u.alpha_shift);
    }
    return range_fault(cfg, in, &axis[hal_axis_z]);
}

/// One of the slow tasks. @return faults that it found
static uint32_t work_ahead(cam_play_t *p, const cam_play_config_t *cfg, const cam_sense_t *in,
                           const cam_angle_t *angle, cam_move_t *axis, uint32_t theta_q32)
{
    switch (p->task++ % cam_play_tasks) {
    case 0:
        plan(p, cfg, in, angle);
        return 0;
    case 1:
        aim_all(p, cfg, axis);
        return 0;
    case 2:
        read_ratio(p, cfg, angle->speed_q32, theta_q32);
        return 0;
    default:
        return modulate(p, cfg, in, axis);
    }
}

static void advance(cam_move_t *m)
{
    m->pos_q10 += m->vel_q10;
}

/// All axes from the angle: U exactly, X and Z on their way.
static void play_table(cam_play_t *p, const cam_play_config_t *cfg, const cam_sense_t *in,
                       const cam_angle_t *angle, cam_move_t *axis, cam_want_t *want)
{
    const uint32_t angle_q32 = cam_angle_of_pos(ahead(angle, cfg->lead_q16));
    const uint32_t theta_q32 = angle_q32 - (uint32_t)p->phase_q32;
    want->faults |= work_ahead(p, cfg, in, angle, axis, theta_q32);
    advance(&axis[hal_axis_x]);
    advance(&axis[hal_axis_z]);
    p->phase_q32 = cam_wrap_add(p->phase_q32, p->phase_way_q32);
    p->scale_q30 += p->scale_way_q30;
    const int32_t set_nm = (int32_t)(axis[hal_axis_z].pos_q10 >> 10);
    want->z_nm = cfg->is_z_measured ? in->actual_nm[hal_axis_z] : set_nm - p->z_behind_nm;
    want->u_set_q6 = surface(p, cfg, angle->speed_q32, theta_q32, want->z_nm, &axis[hal_axis_u]);
}

/// Tool out of the work, feed axes at rest. @return true when all of them rest
static bool wait_retracted(const cam_play_config_t *cfg, cam_move_t *axis)
{
    const cam_move_limits_t *limits = cfg->approach;
    const bool is_u_there =
        cam_move_to_isr(&axis[hal_axis_u], &limits[hal_axis_u], cfg->u_retract_q10);
    const bool is_x_there = cam_move_stop_isr(&axis[hal_axis_x], &limits[hal_axis_x]);
    const bool is_z_there = cam_move_stop_isr(&axis[hal_axis_z], &limits[hal_axis_z]);
    return is_u_there && is_x_there && is_z_there;
}

/// The cut is laid onto whole turns of the master; everything is at its start.
static void lay(cam_play_t *p, const cam_play_config_t *cfg, const cam_angle_t *angle, int32_t z_nm)
{
    p->engage_at_q32 = cam_angle_next_turn(furthest_q32(cfg, angle));
    p->feed_at_q32 = p->engage_at_q32 + cfg->engage_q32;
    p->feed_turns_q32 = cfg->feed_q32;
    p->disengage_at_q32 = cfg->is_z_measured ? NEVER_Q32 : p->feed_at_q32 + cfg->feed_q32;
    p->phase_q32 = cfg->phase_q32;
    p->phase_way_q32 = 0;
    p->amplitude_q30 = cfg->amplitude_q30;
    p->scale_q30 = 0;
    p->scale_way_q30 = 0;
    p->measured_z_nm = z_nm;
    p->z_behind_nm = 0;
    p->task = 0;
    p->is_approaching = false;
}

/// Axes to the start of the cut.
static void approach(cam_play_t *p, const cam_play_config_t *cfg, const cam_sense_t *in,
                     const cam_angle_t *angle, cam_move_t *axis)
{
    const cam_move_limits_t *limits = cfg->approach;
    const int32_t z_nm = cfg->is_z_measured ? in->actual_nm[hal_axis_z] : cfg->z_first_nm;
    const int64_t x_q10 = profile_q10(cfg, z_nm) + cfg->x_clearance_q10;
    const bool is_u_there = cam_move_to_isr(&axis[hal_axis_u], &limits[hal_axis_u], 0);
    const bool is_x_there = cam_move_to_isr(&axis[hal_axis_x], &limits[hal_axis_x], x_q10);
    const bool is_z_there =
        cam_move_to_isr(&axis[hal_axis_z], &limits[hal_axis_z], (int64_t)z_nm * 1024);
    if (is_u_there && is_x_there && (is_z_there || cfg->is_z_measured)) {
        lay(p, cfg, angle, z_nm);
    }
}

static void follow_axes(const cam_sense_t *in, cam_move_t *axis)
{
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        axis[i] = (cam_move_t){.pos_q10 = (int64_t)in->actual_nm[i] * 1024};
    }
}

/// Stop lays the end of the feed, and behind it that of the cut, onto the next whole turn that no
/// axis has been told of yet. A feed in motion falls over its ramp, one that has not begun does not
/// begin.
static void stop(cam_play_t *p, const cam_play_config_t *cfg, const cam_angle_t *angle)
{
    if (p->is_approaching) {
        p->state = cam_state_ready;
        return;
    }
    const int64_t at_q32 = cam_angle_next_turn(furthest_q32(cfg, angle));
    const int64_t fed_q32 = at_q32 - p->feed_at_q32;
    const int64_t ramp_q32 = cfg->ramp_q32;
    const bool is_feeding = fed_q32 > 0 && !cfg->is_z_measured;
    const int64_t turns_q32 = !is_feeding          ? 0
                              : fed_q32 > ramp_q32 ? fed_q32 + ramp_q32
                                                   : 2 * ramp_q32;
    const int64_t end_q32 = is_feeding ? p->feed_at_q32 + turns_q32 : at_q32;
    if (end_q32 < p->disengage_at_q32) {
        p->feed_turns_q32 = turns_q32;
        p->disengage_at_q32 = end_q32;
    }
}

/// Carry out a new request if it fits the state. @return faults that the request reports
CAM_STAGE static uint32_t obey(cam_play_t *p, const cam_play_config_t *cfg, uint32_t request,
                               const cam_angle_t *angle)
{
    p->request = request >> 8;
    switch ((cam_request_t)(request & 0xFFu)) {
    case cam_request_enable:
        p->state = p->state == cam_state_off && cfg->table != NULL ? cam_state_homing : p->state;
        break;
    case cam_request_disable:
        p->state = cam_state_is_in_work(p->state) || p->state == cam_state_fault ? p->state
                                                                                 : cam_state_off;
        break;
    case cam_request_start:
        if (p->state == cam_state_ready) {
            p->state = cam_state_engaging;
            p->is_approaching = true;
        }
        break;
    case cam_request_stop:
        if (p->state == cam_state_engaging || p->state == cam_state_cutting) {
            stop(p, cfg, angle);
        }
        break;
    case cam_request_reset:
        p->state = p->state == cam_state_fault && p->is_retracted ? cam_state_off : p->state;
        break;
    case cam_request_table_fault:
        return CAM_FAULT_BIT(table);
    case cam_request_none:
        break;
    }
    return 0;
}

/// U set-point of lead ticks ago, between two of them: that is where the drive should be now.
static int32_t due_q6(const cam_play_t *p, const cam_play_config_t *cfg)
{
    const uint32_t newer = p->n_history - 1u - ((uint32_t)cfg->lead_q16 >> 16);
    const int32_t a_q6 = p->history_q6[newer % cam_play_history];
    const int32_t b_q6 = p->history_q6[(newer - 1u) % cam_play_history];
    const int64_t apart_q6 = (int64_t)b_q6 - a_q6; // while off, whatever the axis measures
    return (int32_t)(a_q6 + ((apart_q6 * (cfg->lead_q16 & 0xFFFF)) >> 16));
}

static void remember(cam_play_t *p, int32_t u_q6)
{
    p->history_q6[p->n_history % cam_play_history] = u_q6;
    p->n_history++;
}

/// Everything that is not a cut: the axes move by time. @return [nm / 64] U
CAM_STAGE static int32_t move_axes(cam_play_t *p, const cam_play_config_t *cfg,
                                   const cam_sense_t *in, const cam_angle_t *angle,
                                   cam_move_t *axis)
{
    p->speed = (cam_speed_t){.spindle_mrpm = cfg->spindle_mrpm};
    p->alpha_u = 0;
    if (p->state == cam_state_off) {
        follow_axes(in, axis);
    } else if (p->state == cam_state_engaging) {
        approach(p, cfg, in, angle, axis);
    } else if (p->state != cam_state_fault) {
        const bool is_out = wait_retracted(cfg, axis);
        const bool is_homed = angle->is_synced && angle->speed_q32 >= cfg->turning_q32;
        p->state = p->state == cam_state_homing && is_homed && is_out ? cam_state_ready : p->state;
    }
    return cam_sat_i32(axis[hal_axis_u].pos_q10 >> 4);
}

void cam_play_step_isr(cam_play_t *p, const cam_play_config_t *cfg, const cam_sense_t *in,
                       const cam_angle_t *angle, cam_move_t *axis, cam_want_t *want)
{
    want->faults = in->request >> 8 != p->request ? obey(p, cfg, in->request, angle) : 0u;
    if (cam_state_is_in_work(p->state) && !p->is_approaching) {
        play_table(p, cfg, in, angle, axis, want);
    } else {
        want->z_nm = in->actual_nm[hal_axis_z];
        want->u_set_q6 = move_axes(p, cfg, in, angle, axis);
    }
    remember(p, want->u_set_q6);
    const bool is_idle = p->state == cam_state_off || p->state == cam_state_fault;
    want->state = p->state;
    want->u_due_q6 = due_q6(p, cfg);
    want->spindle_mrpm = is_idle ? 0 : p->speed.spindle_mrpm;
}
