// SPDX-License-Identifier: Apache-2.0
#include "cam_build_motion.h"
#include "cam_angle.h"          // CAM_TURN_Q32
#include "cam_cut.h"            // cam_cut_smaller
#include "cam_derived_limits.h" // cam_derived_limits_approach_share
#include "cam_fix.h"            // cam_clamp_i64, cam_sat_i32
#include "cam_gains.h"          // cam_gains_log2_window
#include "cam_jerk_filter.h"    // cam_jerk_filter_most_q10
#include "cam_units.h"          // cam_units_scale

/// Speeds and accelerations beyond 2^29 per tick are limited: slower than allowed is safe.
static cam_motion_limits_t limits(int32_t speed_um_per_s, int32_t acceleration_mm_per_s2,
                                  uint32_t tick_hz)
{
    const int64_t most = INT64_C(1) << 29; // a speed and an acceleration fit a word together
    const int64_t vel = cam_units_scale(speed_um_per_s, 1024000, tick_hz);
    const int64_t acc =
        cam_units_scale(acceleration_mm_per_s2, 1024000000, (int64_t)tick_hz * tick_hz);
    return (cam_motion_limits_t){
        .speed_q10 = (int32_t)cam_clamp_i64(vel, 1, most),
        .acceleration_q10 = (int32_t)cam_clamp_i64(acc, 1, most),
    };
}

/// @return limits per plan instead of per tick
static cam_motion_limits_t per_plan(cam_motion_limits_t limits, int32_t plan_ticks)
{
    const int64_t most = INT64_C(1) << 29;
    const int64_t speed = (int64_t)limits.speed_q10 * plan_ticks;
    const int64_t acceleration = (int64_t)limits.acceleration_q10 * plan_ticks * plan_ticks;
    return (cam_motion_limits_t){
        .speed_q10 = (int32_t)cam_clamp_i64(speed, 1, most),
        .acceleration_q10 = (int32_t)cam_clamp_i64(acceleration, 1, most),
    };
}

/// @return limits with their window, which carries no acceleration beyond 2^30 / n
static cam_motion_limits_t windowed(cam_motion_limits_t limits, uint32_t log2_window)
{
    const int32_t most_q10 = cam_jerk_filter_most_q10(log2_window);
    limits.acceleration_q10 =
        limits.acceleration_q10 < most_q10 ? limits.acceleration_q10 : most_q10;
    limits.log2_window = log2_window;
    return limits;
}

/// U moves tick by tick, X and Z plan by plan.
static void build_limits(cam_config_t *c, const cam_params_t *p, uint32_t tick_hz)
{
    const cam_motion_limits_t full[hal_n_axes] = {
        [hal_axis_u] = limits(p->u_speed_um_per_s, p->u_acceleration_mm_per_s2, tick_hz),
        [hal_axis_x] = limits(p->x_speed_um_per_s, p->x_acceleration_mm_per_s2, tick_hz),
        [hal_axis_z] = limits(p->z_speed_um_per_s, p->z_acceleration_mm_per_s2, tick_hz),
    };
    c->guard.u = full[hal_axis_u];
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        const int32_t ticks = i == (uint32_t)hal_axis_u ? 1 : c->play.plan_ticks;
        const cam_motion_limits_t gentle = {
            .speed_q10 = full[i].speed_q10 / cam_derived_limits_approach_share + 1,
            .acceleration_q10 = full[i].acceleration_q10 / cam_derived_limits_approach_share + 1,
        };
        const uint32_t log2 = cam_gains_log2_window(p, (hal_axis_t)i, tick_hz);
        c->play.approach[i] = windowed(per_plan(gentle, ticks), log2);
        c->play.leave[i] = windowed(per_plan(full[i], ticks), log2);
    }
}

/// @return [nm per turn] fastest way of X or Z with the spindle's angle: Z moves by the feed, and X
/// also leaves or reaches its clearance by a smooth step over whole turns, at 15/8 of its mean
static int64_t way_nm(const cam_play_config_t *c, uint32_t axis)
{
    const int64_t ramp_q32 = cam_cut_smaller(c->engage_q32, c->disengage_q32);
    const int64_t clearing_nm = (int64_t)c->x_clearance_nm * 15 / (8 * (ramp_q32 / CAM_TURN_Q32));
    return axis == (uint32_t)hal_axis_x ? c->feed_nm + clearing_nm : c->feed_nm;
}

/// @return [counts] by how much the place that X and Z are aimed at changes beyond the spindle's
/// speed when its acceleration goes from one end of what it can to the other: what is read ahead
/// by the square of the time, which covers the time from plan to plan
static int32_t swung_counts(const cam_config_t *c, const cam_params_t *p, uint32_t tick_hz)
{
    const int64_t per_mrad_q32 = 683566; // 2^32 / 2000 pi
    const int64_t alpha_q32 = cam_units_scale(p->spindle_acceleration_mrad_per_s2, per_mrad_q32,
                                              (int64_t)tick_hz * tick_hz);
    const int64_t ahead_q1 = (c->play.xz_plan_q16 >> 15) + 1; // rounded up, as the acceleration
    const int64_t turn_q32 =
        cam_cut_smaller(ahead_q1 * ahead_q1 * (alpha_q32 + 1) >> 2, INT64_C(1) << 32);
    return (int32_t)((turn_q32 * c->spindle.counts_per_turn) >> 32) + 1;
}

/// @return [counts] what moves the place that X and Z are aimed at from plan to plan: the spindle's
/// acceleration, and a step of the encoder within the jump window, or a count and what the observer
/// makes of it. That is a speed of w T counts per tick, which the reading ahead multiplies; half of
/// it was seen at most. More than a quarter of a turn is none of the spindle's.
static int32_t unrest_counts(const cam_config_t *c, const cam_params_t *p, uint32_t tick_hz)
{
    const int64_t ahead_q47 = (int64_t)c->spindle.kp_q31 * c->play.xz_plan_q16; // kp = 2 w T
    const int32_t observed = 1 + (int32_t)(ahead_q47 >> 49);
    const int32_t seen = observed > c->spindle.jump_window ? observed : c->spindle.jump_window;
    return (int32_t)cam_cut_smaller((int64_t)seen + swung_counts(c, p, tick_hz),
                                    c->spindle.counts_per_turn / 4);
}

/// What X and Z are told changes from plan to plan by their acceleration, and by what the encoder
/// makes of it: they follow the spindle's angle, whose unrest moves them by their share of the way
/// of a turn. Twice of both is no fault, nor is a speed that is beyond its limit by one of it. A Z
/// that others move is told where it is, and an X over it follows its measurement from plan to
/// plan.
static void build_told(cam_config_t *c, const cam_params_t *p, uint32_t tick_hz)
{
    const int32_t ticks = c->play.plan_ticks;
    const int64_t unrest = unrest_counts(c, p, tick_hz);
    cam_axis_command_config_t *t = &c->command;
    for (uint32_t i = (uint32_t)hal_axis_x; i <= (uint32_t)hal_axis_z; i++) {
        const cam_motion_limits_t *full = &c->play.leave[i]; // per plan
        const int64_t vel_q10 = full->speed_q10 / ticks;
        const int64_t change_q10 = full->acceleration_q10 / ticks;
        const int64_t ticks_counts = (int64_t)c->spindle.counts_per_turn * ticks;
        const int64_t unrest_q10 = way_nm(&c->play, i) * unrest * 256 / ticks_counts * 4;
        const int64_t most_q10 = vel_q10 + vel_q10 / 16 + unrest_q10 + CAM_BUILD_MARGIN_Q10;
        const bool is_led = c->play.is_z_measured && i == (uint32_t)hal_axis_z;
        const int64_t told_q10 = 2 * (change_q10 + unrest_q10) + CAM_BUILD_MARGIN_Q10;
        t->vel_q10[i] = is_led ? INT32_MAX : cam_sat_i32(most_q10);
        t->change_q10[i] =
            is_led ? INT32_MAX : cam_sat_i32(c->play.is_z_measured ? 2 * most_q10 : told_q10);
        t->jump_q10[i] = is_led ? INT32_MAX : 4 * ticks; // what equal increments leave
    }
}

/// @return [nm / 1024 per tick^2] the largest acceleration of a retract that tells U no more than
/// three quarters of its speed while it begins: a (n / 2 + k1 + k2 / n) ticks, MATHS.md (212)
static int64_t most_acceleration_q10(const cam_config_t *c, uint32_t log2_window)
{
    const int64_t n_q16 = INT64_C(65536) << log2_window;
    const int64_t ticks_q16 = n_q16 / 2 + c->command.k1_q16 + (c->command.k2_q16 >> log2_window);
    return (int64_t)c->guard.u.speed_q10 * 49152 / ticks_q16 + 1;
}

/// @return [ticks / 2^16] times the acceleration: by how much the command of U runs ahead at the
/// highest speed of a retract. While the acceleration falls from a to 0 in n ticks U is slower by
/// m (m - 1) a / 2 n with m of them left, and told k1 m a / n more and k2 a / n less: that is most
/// at m = k1 + 1/2, which counts in short windows; in a window shorter than twice k1 it is k1 -
/// n/2. MATHS.md (212)
static int32_t ahead_ticks_q16(const cam_config_t *c, uint32_t log2_window)
{
    const int32_t k1_q8 = c->command.k1_q16 >> 8;
    const int32_t m_q8 = cam_clamp_i32(k1_q8 + 128, 0, INT32_C(256) << log2_window);
    const int64_t told_q16 = ((int64_t)(2 * k1_q8 + 256 - m_q8) * m_q8) >> 1;
    const int32_t falling_q16 = cam_sat_i32((told_q16 - c->command.k2_q16) >> log2_window);
    const int32_t over_q16 = c->command.k1_q16 - (INT32_C(32768) << log2_window);
    const int32_t more_q16 = over_q16 > falling_q16 ? over_q16 : falling_q16;
    return more_q16 > 0 ? more_q16 : 0;
}

/// The command of U runs ahead of U by the feed-forward. So the retract begins with less than the
/// acceleration of U where that told too much, and it is so much slower as the command runs ahead
/// at its speed, and a sixteenth for what fades meanwhile; but not slower than a quarter. MATHS.md
/// (212).
static cam_motion_limits_t leaving(const cam_config_t *c, uint32_t log2_window)
{
    const cam_motion_limits_t *u = &c->guard.u;
    const int64_t a_q10 =
        cam_cut_smaller(u->acceleration_q10, most_acceleration_q10(c, log2_window));
    const int64_t ahead_q10 = (ahead_ticks_q16(c, log2_window) * a_q10) >> 16;
    const int64_t least_q10 = u->speed_q10 / 4 + 1;
    const int64_t most_q10 = u->speed_q10 - u->speed_q10 / 16 - ahead_q10;
    const cam_motion_limits_t gentle = {
        .speed_q10 = (int32_t)cam_clamp_i64(most_q10, least_q10, u->speed_q10),
        .acceleration_q10 = (int32_t)a_q10,
    };
    return windowed(gentle, log2_window);
}

/// @return [ticks^2 / 2^8] times the acceleration: by how much the command passes the end of a
/// motion, where U begins to brake, or brakes, whichever is more. MATHS.md (214)
static int64_t passed_q8(const cam_axis_command_config_t *t, uint32_t log2_window)
{
    const int32_t n = INT32_C(1) << log2_window;
    const int32_t k1_q8 = t->k1_q16 >> 8;
    const int32_t over_q8 = k1_q8 + 128 - n * 128;
    const int64_t brakes_q17 = (int64_t)k1_q8 * ((int64_t)k1_q8 + 256);
    const int64_t brakes_q8 = (brakes_q17 >> 9) - ((t->k2_q16 - (t->k2_q16 >> log2_window)) >> 8);
    const int64_t begins_q8 = (((int64_t)over_q8 * over_q8) >> 9) + n * n * 64 / 3;
    const int64_t most_q8 = over_q8 > 0 && begins_q8 > brakes_q8 ? begins_q8 : brakes_q8;
    return most_q8 > 0 ? most_q8 : 0;
}

int64_t cam_build_room_q10(const cam_config_t *config)
{
    const cam_motion_limits_t *leave = &config->guard.leave;
    const int64_t approach_q10 = config->play.approach[hal_axis_u].acceleration_q10;
    const int64_t leave_q10 = leave->acceleration_q10;
    const int64_t a_q10 = leave_q10 > approach_q10 ? leave_q10 : approach_q10;
    const int64_t ahead_q10 = (a_q10 * passed_q8(&config->command, leave->log2_window)) >> 8;
    return config->guard.u.acceleration_q10 / 8 + ahead_q10;
}

void cam_build_motion(cam_config_t *config, const cam_params_t *params, uint32_t tick_hz)
{
    build_limits(config, params, tick_hz);
    config->guard.leave = leaving(config, cam_gains_log2_window(params, hal_axis_u, tick_hz));
    build_told(config, params, tick_hz);
}
