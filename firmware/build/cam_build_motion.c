// SPDX-License-Identifier: Apache-2.0
#include "cam_build_inner.h"
#include "cam_fix.h"      // CAM_TURN_Q32, cam_clamp_i64, cam_root_u64
#include "cam_feasible.h" // cam_derived_limits_approach_share
#include "cam_motion.h"   // cam_jerk_filter_most_q10

/// [nm / 1024 per tick or plan] limit of speeds and accelerations, so that their sum fits a word
#define MOST_Q10 (INT64_C(1) << 29)

static cam_motion_limits_t limits(int32_t speed_um_per_s, int32_t acceleration_mm_per_s2,
                                  uint32_t tick_hz)
{
    const int64_t vel = cam_units_scale(speed_um_per_s, 1024000, tick_hz);
    const int64_t acc =
        cam_units_scale(acceleration_mm_per_s2, 1024000000, (int64_t)tick_hz * tick_hz);
    return (cam_motion_limits_t){
        .speed_q10 = (int32_t)cam_clamp_i64(vel, 1, MOST_Q10),
        .acceleration_q10 = (int32_t)cam_clamp_i64(acc, 1, MOST_Q10),
    };
}

/// @return limits per plan instead of per tick
static cam_motion_limits_t per_plan(cam_motion_limits_t limits, int32_t plan_ticks)
{
    const int64_t speed = (int64_t)limits.speed_q10 * plan_ticks;
    const int64_t acceleration = (int64_t)limits.acceleration_q10 * plan_ticks * plan_ticks;
    return (cam_motion_limits_t){
        .speed_q10 = (int32_t)cam_clamp_i64(speed, 1, MOST_Q10),
        .acceleration_q10 = (int32_t)cam_clamp_i64(acceleration, 1, MOST_Q10),
    };
}

/// @return limits with their jerk window; its sum of n values limits the acceleration to 2^30 / n
static cam_motion_limits_t windowed(cam_motion_limits_t limits, uint32_t log2_window)
{
    const int32_t most_q10 = cam_jerk_filter_most_q10(log2_window);
    limits.acceleration_q10 =
        limits.acceleration_q10 < most_q10 ? limits.acceleration_q10 : most_q10;
    limits.log2_window = log2_window;
    return limits;
}

/// U moves per tick, X and Z per plan.
static void build_limits(cam_config_t *c, const cam_params_t *p, uint32_t tick_hz)
{
    const cam_motion_limits_t full[hal_n_axes] = {
        [hal_axis_u] = limits(p->u_speed_um_per_s, p->u_acceleration_mm_per_s2, tick_hz),
        [hal_axis_x] = limits(p->x_speed_um_per_s, p->x_acceleration_mm_per_s2, tick_hz),
        [hal_axis_z] = limits(p->z_speed_um_per_s, p->z_acceleration_mm_per_s2, tick_hz),
    };
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
    c->guard.u = c->play.leave[hal_axis_u];
}

/// @return [counts] change of the predicted position from plan to plan, beyond that of the speed,
///         when the spindle's acceleration reverses: the prediction by the square of the time
static int32_t reversal_counts(const cam_config_t *c, const cam_params_t *p, uint32_t tick_hz)
{
    const int64_t per_mrad_q32 = 683566; // 2^32 / 2000 pi
    const int64_t alpha_q32 = cam_units_scale(p->spindle_acceleration_mrad_per_s2, per_mrad_q32,
                                              (int64_t)tick_hz * tick_hz);
    const int64_t ahead_q1 = (c->play.xz_plan_q16 >> 15) + 1; // rounded up, like the acceleration
    const int64_t turn_q32 =
        cam_smaller_i64(ahead_q1 * ahead_q1 * (alpha_q32 + 1) >> 2, INT64_C(1) << 32);
    return (int32_t)((turn_q32 * c->spindle.counts_per_turn) >> 32) + 1;
}

/// @return [counts] change of the predicted position from plan to plan: the reversal of the
///         spindle's acceleration, and a step of the encoder within the jump window or the
///         observer's response to a count: w T counts per tick times the prediction, of which half
///         is the most seen. At most a quarter of a turn.
static int32_t prediction_counts(const cam_config_t *c, const cam_params_t *p, uint32_t tick_hz)
{
    const int64_t ahead_q47 = (int64_t)c->spindle.kp_q31 * c->play.xz_plan_q16; // kp = 2 w T
    const int32_t observed = 1 + (int32_t)(ahead_q47 >> 49);
    const int32_t seen = observed > c->spindle.jump_window ? observed : c->spindle.jump_window;
    return (int32_t)cam_smaller_i64((int64_t)seen + reversal_counts(c, p, tick_hz),
                                    c->spindle.counts_per_turn / 4);
}

/// Limits of the commands of X and Z from plan to plan: twice the change by their acceleration and
/// by the noise of the spindle's angle times their travel per turn; for the speed once. Z travels
/// by the feed; X also by its clearance, as a smooth step over whole turns at 15/8 of its mean
/// speed. A measured Z is not limited, and X follows its measurement from plan to plan.
static void build_command(cam_config_t *c, const cam_params_t *p, uint32_t tick_hz)
{
    const int32_t ticks = c->play.plan_ticks;
    const int64_t noise = prediction_counts(c, p, tick_hz);
    const int64_t ramp_q32 = cam_smaller_i64(c->play.engage_q32, c->play.disengage_q32);
    const int64_t clearing_nm =
        (int64_t)c->play.x_clearance_nm * 15 / (8 * (ramp_q32 / CAM_TURN_Q32));
    cam_axis_command_config_t *t = &c->command;
    for (uint32_t i = (uint32_t)hal_axis_x; i <= (uint32_t)hal_axis_z; i++) {
        const cam_motion_limits_t *full = &c->play.leave[i]; // per plan
        const int64_t vel_q10 = full->speed_q10 / ticks;
        const int64_t change_q10 = full->acceleration_q10 / ticks;
        const int64_t ticks_counts = (int64_t)c->spindle.counts_per_turn * ticks;
        const int64_t travel_nm =
            c->play.feed_nm + (i == (uint32_t)hal_axis_x ? clearing_nm : 0); // per turn
        const int64_t noise_q10 = travel_nm * noise * 256 / ticks_counts * 4;
        const int64_t most_q10 = vel_q10 + vel_q10 / 16 + noise_q10 + CAM_BUILD_MARGIN_Q10;
        const bool is_measured = c->play.is_z_measured && i == (uint32_t)hal_axis_z;
        const int64_t command_q10 = 2 * (change_q10 + noise_q10) + CAM_BUILD_MARGIN_Q10;
        t->vel_q10[i] = is_measured ? INT32_MAX : cam_sat_i32(most_q10);
        t->change_q10[i] = is_measured
                               ? INT32_MAX
                               : cam_sat_i32(c->play.is_z_measured ? 2 * most_q10 : command_q10);
        t->jump_q10[i] = is_measured ? INT32_MAX : 4 * ticks; // rounding of equal increments
    }
}

void cam_build_motion(cam_config_t *config, const cam_params_t *params, uint32_t tick_hz)
{
    build_limits(config, params, tick_hz);
    build_command(config, params, tick_hz);
}

/// @return limits of jogging: no faster than an axis can brake within the 2^31 units that
///         cam_move_profile_to_isr() looks ahead, v (v + a) <= 2 a 2^31
static cam_motion_limits_t jog_limits(int32_t jog_um_per_s, int32_t speed_um_per_s,
                                      int64_t acceleration_q10, int32_t plan_ticks,
                                      uint32_t tick_hz)
{
    const int32_t um_per_s = jog_um_per_s < speed_um_per_s ? jog_um_per_s : speed_um_per_s;
    const int64_t a_q10 = cam_clamp_i64(acceleration_q10, 1, MOST_Q10);
    const int64_t root_q10 = (int64_t)cam_root_u64((uint64_t)a_q10 << 32);
    const int64_t most_q10 = cam_clamp_i64(root_q10 - a_q10, 1, MOST_Q10);
    const int64_t speed_q10 = (int64_t)um_per_s * 1024000 * plan_ticks / tick_hz;
    return (cam_motion_limits_t){.speed_q10 = (int32_t)cam_clamp_i64(speed_q10, 1, most_q10),
                                 .acceleration_q10 = (int32_t)a_q10};
}

void cam_build_jog(cam_config_t *config, const cam_params_t *params, uint32_t tick_hz)
{
    const cam_params_t *p = params;
    const cam_motion_limits_t *gentle = config->play.approach;
    const int32_t n = config->play.plan_ticks;
    cam_jog_config_t *jog = &config->play.jog;
    // U moves per tick, but its jog speed is per plan as for X and Z.
    const int64_t u_q10 = (int64_t)gentle[hal_axis_u].acceleration_q10 * n * n;
    jog->limits[hal_axis_u] = jog_limits(p->u_jog_um_per_s, p->u_speed_um_per_s, u_q10, n, tick_hz);
    jog->limits[hal_axis_u].acceleration_q10 = gentle[hal_axis_u].acceleration_q10;
    jog->limits[hal_axis_x] = jog_limits(p->x_jog_um_per_s, p->x_speed_um_per_s,
                                         gentle[hal_axis_x].acceleration_q10, n, tick_hz);
    jog->limits[hal_axis_z] = jog_limits(p->z_jog_um_per_s, p->z_speed_um_per_s,
                                         gentle[hal_axis_z].acceleration_q10, n, tick_hz);
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        jog->limits[i].log2_window = gentle[i].log2_window;
    }
    // Braking in steps may overshoot by an eighth of the acceleration (cam_motion.h).
    const int64_t over_q10 = jog->limits[hal_axis_u].acceleration_q10 / 8 + 1024;
    const int64_t end_q10 = (int64_t)p->u_stroke_nm * 512 - over_q10;
    jog->u_end_q10 = cam_clamp_i64(end_q10, 0, INT64_MAX) / 1024 * 1024;
}
