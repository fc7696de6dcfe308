// SPDX-License-Identifier: Apache-2.0
#include "cam/cam_play.h"
#include "cam/cam_angle.h" // cam_angle_next_turn
#include "cam/cam_eval.h"  // cam_eval_surface
#include "cam/cam_fix.h"   // cam_clamp_i32

/// Disengage position while nobody asked for one.
#define NEVER_Q32 (INT64_MAX / 2)

/// Knots per tick that keep the derivatives within 64 bits; start refuses speeds beyond.
#define MAX_RATE_Q24 (INT32_C(16) << 24)

/// Where U and speed are read from the table.
typedef struct {
    uint32_t theta_q32;   ///< [turn / 2^32] from the long axis, phase included
    int32_t z_nm;         ///< [nm]
    int32_t envelope_q30; ///< [1 / 2^30]
} cam_place_t;

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

static int64_t ahead(const cam_angle_t *angle, int32_t ticks_q16)
{
    return angle->pos_q32 + (((int64_t)angle->speed_q32 * ticks_q16) >> 16);
}

/// @return [turn] the furthest position that any axis is told of in this tick
static int64_t furthest_q32(const cam_play_config_t *cfg, const cam_angle_t *angle)
{
    return ahead(angle, cfg->lead_q16 > cfg->xz_lag_q16 ? cfg->lead_q16 : cfg->xz_lag_q16);
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

/// Knots of u per tick^2 that the spindle's acceleration means, limited to 1/16: with |d1| < 2^26
/// products stay below 2^62.
static int64_t knots_alpha_q40(const cam_play_t *p, const cam_play_config_t *cfg)
{
    const int64_t most_q40 = INT64_C(1) << 36;
    const int64_t knots_q40 = (p->speed.alpha_q48 * (INT64_C(1) << cfg->knots_shift)) >> 8;
    return cam_clamp_i64(knots_q40, -most_q40, most_q40);
}

/// U with its velocity and acceleration: derivatives per knot times knots per tick. The slow change
/// of envelope, amplitude and height adds nothing worth naming to them (a skirt: 1e-6 of the
/// speed).
static cam_move_t surface(const cam_play_t *p, const cam_play_config_t *cfg,
                          const cam_angle_t *angle, const cam_place_t *at)
{
    const cam_channel_t *u = &cfg->table->u;
    const cam_value_t value = cam_eval_surface(u, at->theta_q32, at->z_nm);
    const int32_t amp_q30 = cam_mul_shift(at->envelope_q30, p->amplitude_q30, 30);
    const int64_t knots_q24 = ((int64_t)angle->speed_q32 * (INT64_C(1) << cfg->knots_shift)) >> 8;
    const int64_t rate_q24 = cam_clamp_i64(knots_q24, -MAX_RATE_Q24, MAX_RATE_Q24);
    const int64_t vel_q10 = (value.d1 * rate_q24) >> (14u + u->frac_bits);
    const int64_t curve_q10 = (value.d2 * ((rate_q24 * rate_q24) >> 24)) >> (14u + u->frac_bits);
    const int64_t acc_q10 =
        curve_q10 + ((value.d1 * knots_alpha_q40(p, cfg)) >> (30u + u->frac_bits));
    const int64_t offset_q10 = ((int64_t)u->offset_nm * amp_q30) >> 20;
    return (cam_move_t){
        .pos_q10 = (((int64_t)value.y * amp_q30) >> (20u + u->frac_bits)) + offset_q10,
        .vel_q10 = (int32_t)((cam_sat_i32(vel_q10) * (int64_t)amp_q30) >> 30),
        .acc_q10 = (int32_t)((cam_sat_i32(acc_q10) * (int64_t)amp_q30) >> 30),
    };
}

static void ramp(cam_play_t *p, const cam_play_config_t *cfg)
{
    const int32_t phase_left = cam_angle_diff_q32((uint32_t)cfg->phase_q32, (uint32_t)p->phase_q32);
    p->phase_q32 =
        (int32_t)((uint32_t)p->phase_q32 +
                  (uint32_t)cam_clamp_i32(phase_left, -cfg->phase_step_q32, cfg->phase_step_q32));
    const int32_t amplitude_left = cfg->amplitude_q30 - p->amplitude_q30;
    p->amplitude_q30 +=
        cam_clamp_i32(amplitude_left, -cfg->amplitude_step_q30, cfg->amplitude_step_q30);
}

static cam_state_t state_at(const cam_play_t *p, const cam_play_config_t *cfg, int64_t pos_q32)
{
    if (pos_q32 >= p->disengage_at_q32) {
        return pos_q32 < p->disengage_at_q32 + cfg->disengage_q32 ? cam_state_disengaging
                                                                  : cam_state_ready;
    }
    return pos_q32 < p->feed_at_q32 ? cam_state_engaging : cam_state_cutting;
}

/// The spindle from its own angle; a table without a speed channel costs this one question.
static void modulate(cam_play_t *p, const cam_play_config_t *cfg, const cam_place_t *at)
{
    const cam_channel_t *speed = &cfg->table->speed;
    if (speed->knots != NULL) {
        const cam_ratio_t ratio = cam_speed_ratio(speed, at->theta_q32, at->z_nm);
        p->speed = cam_speed_law(&cfg->speed, ratio, at->envelope_q30);
    }
}

/// All axes from the angle. @return height played [nm]
static int32_t play_table(cam_play_t *p, const cam_play_config_t *cfg, const cam_sense_t *in,
                          const cam_angle_t *angle)
{
    ramp(p, cfg);
    const int64_t u_pos_q32 = ahead(angle, cfg->lead_q16);
    const int32_t measured_nm = in->actual_nm[hal_axis_z];
    const cam_place_t at = {
        .theta_q32 = cam_angle_of_pos(u_pos_q32) - (uint32_t)p->phase_q32,
        .z_nm = cfg->is_z_measured ? measured_nm : height_nm(p, cfg, u_pos_q32),
        .envelope_q30 = envelope_q30(p, cfg, u_pos_q32),
    };
    modulate(p, cfg, &at);
    const int64_t xz_pos_q32 =
        ahead(angle, cfg->xz_lag_q16) + ((p->speed.alpha_q48 * cfg->xz_lag2) >> 16);
    const int32_t xz_z_nm = cfg->is_z_measured ? measured_nm : height_nm(p, cfg, xz_pos_q32);
    const int32_t out_q30 = (INT32_C(1) << 30) - envelope_q30(p, cfg, xz_pos_q32);
    p->axis[hal_axis_u] = surface(p, cfg, angle, &at);
    p->axis[hal_axis_x].pos_q10 =
        profile_q10(cfg, xz_z_nm) + ((cfg->x_clearance_q10 >> 10) * out_q30 >> 20);
    p->axis[hal_axis_z].pos_q10 = (int64_t)xz_z_nm * 1024;
    p->state = state_at(p, cfg, angle->pos_q32);
    return at.z_nm;
}

static bool go(cam_play_t *p, const cam_play_config_t *cfg, hal_axis_t axis, int64_t target_q10)
{
    return cam_move_to_isr(&p->axis[axis], &cfg->approach[axis], target_q10);
}

static bool stand(cam_play_t *p, const cam_play_config_t *cfg, hal_axis_t axis)
{
    return cam_move_stop_isr(&p->axis[axis], &cfg->approach[axis]);
}

/// Tool out of the work, feed axes at rest. @return true when all of them rest
static bool wait_retracted(cam_play_t *p, const cam_play_config_t *cfg)
{
    const bool is_u_there = go(p, cfg, hal_axis_u, cfg->u_retract_q10);
    const bool is_x_there = stand(p, cfg, hal_axis_x);
    const bool is_z_there = stand(p, cfg, hal_axis_z);
    return is_u_there && is_x_there && is_z_there;
}

/// Axes to the start of the cut; then the cut is laid onto whole turns of the master.
static void approach(cam_play_t *p, const cam_play_config_t *cfg, const cam_sense_t *in,
                     const cam_angle_t *angle)
{
    const int32_t z_nm = cfg->is_z_measured ? in->actual_nm[hal_axis_z] : cfg->z_first_nm;
    const bool is_u_there = go(p, cfg, hal_axis_u, 0);
    const bool is_x_there = go(p, cfg, hal_axis_x, profile_q10(cfg, z_nm) + cfg->x_clearance_q10);
    const bool is_z_there = go(p, cfg, hal_axis_z, (int64_t)z_nm * 1024);
    if (is_u_there && is_x_there && (is_z_there || cfg->is_z_measured)) {
        p->engage_at_q32 = cam_angle_next_turn(furthest_q32(cfg, angle));
        p->feed_at_q32 = p->engage_at_q32 + cfg->engage_q32;
        p->feed_turns_q32 = cfg->feed_q32;
        p->disengage_at_q32 = cfg->is_z_measured ? NEVER_Q32 : p->feed_at_q32 + cfg->feed_q32;
        p->phase_q32 = cfg->phase_q32;
        p->amplitude_q30 = cfg->amplitude_q30;
        p->is_approaching = false;
    }
}

static void follow_axes(cam_play_t *p, const cam_sense_t *in)
{
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        p->axis[i] = (cam_move_t){.pos_q10 = (int64_t)in->actual_nm[i] * 1024};
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
static uint32_t obey(cam_play_t *p, const cam_play_config_t *cfg, const cam_sense_t *in,
                     const cam_angle_t *angle)
{
    if (in->request >> 8 == p->request) {
        return 0;
    }
    p->request = in->request >> 8;
    switch ((cam_request_t)(in->request & 0xFFu)) {
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

static void remember(cam_play_t *p)
{
    p->history_q6[p->n_history % cam_play_history] = cam_sat_i32(p->axis[hal_axis_u].pos_q10 >> 4);
    p->n_history++;
}

/// Measured Z must lie on the table, a geared one moreover where the angle wants it.
static uint32_t range_fault(const cam_play_t *p, const cam_play_config_t *cfg,
                            const cam_sense_t *in, const cam_angle_t *angle)
{
    const int32_t z_nm = in->actual_nm[hal_axis_z];
    const int64_t off_nm = (int64_t)z_nm - height_nm(p, cfg, angle->pos_q32);
    const bool is_off = !cfg->is_z_measured && cam_abs_i64(off_nm) > cfg->z_margin_nm;
    const bool is_out = z_nm < cfg->z_low_nm || z_nm > cfg->z_high_nm;
    return is_off || is_out ? CAM_FAULT_BIT(z_range) : 0u;
}

cam_want_t cam_play_step_isr(cam_play_t *p, const cam_play_config_t *cfg, const cam_sense_t *in,
                             const cam_angle_t *angle)
{
    int32_t z_nm = in->actual_nm[hal_axis_z];
    uint32_t faults = obey(p, cfg, in, angle);
    p->speed = (cam_speed_t){.spindle_mrpm = cfg->spindle_mrpm};
    if (cam_state_is_in_work(p->state) && !p->is_approaching) {
        z_nm = play_table(p, cfg, in, angle);
        faults |= range_fault(p, cfg, in, angle);
    } else if (cam_state_is_in_work(p->state)) {
        approach(p, cfg, in, angle);
    } else if (p->state == cam_state_off) {
        follow_axes(p, in);
    } else if (p->state != cam_state_fault) {
        const bool is_out = wait_retracted(p, cfg);
        const bool is_homed = angle->is_synced && angle->speed_q32 >= cfg->turning_q32;
        p->state = p->state == cam_state_homing && is_homed && is_out ? cam_state_ready : p->state;
    }
    remember(p);
    const bool is_idle = p->state == cam_state_off || p->state == cam_state_fault;
    return (cam_want_t){
        .state = p->state,
        .axis = {p->axis[hal_axis_u], p->axis[hal_axis_x], p->axis[hal_axis_z]},
        .z_nm = z_nm,
        .u_due_q6 = due_q6(p, cfg),
        .spindle_mrpm = is_idle ? 0 : p->speed.spindle_mrpm,
        .faults = faults,
    };
}

void cam_play_settle_isr(cam_play_t *p, cam_state_t state, const cam_move_t axis[hal_n_axes],
                         bool is_retracted)
{
    p->state = state;
    p->is_retracted = is_retracted;
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        p->axis[i] = axis[i];
    }
}
