// SPDX-License-Identifier: Apache-2.0
#include "cam_build_jog.h"
#include "cam_build_motion.h" // cam_build_room_q10
#include "cam_fix.h"          // cam_clamp_i64, cam_root_u64

/// [nm / 1024 per plan, per plan^2] as the limits of approaches, so that a sum fits a word.
#define MOST_Q10 (INT64_C(1) << 29)

/// @return limits by hand: no faster than the axis can brake from within the 2^31 units that
///         cam_move_profile_to_isr() looks ahead, v (v + a) <= 2 a 2^31
static cam_motion_limits_t by_hand(int32_t jog_um_per_s, int32_t speed_um_per_s,
                                   int64_t acceleration_q10, int32_t plan_ticks, uint32_t tick_hz)
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
    cam_jog_config_t *hand = &config->play.jog;
    // U moves from tick to tick, and its speeds are told per plan as those of the others.
    const int64_t u_q10 = (int64_t)gentle[hal_axis_u].acceleration_q10 * n * n;
    hand->limits[hal_axis_u] = by_hand(p->u_jog_um_per_s, p->u_speed_um_per_s, u_q10, n, tick_hz);
    hand->limits[hal_axis_u].acceleration_q10 = gentle[hal_axis_u].acceleration_q10;
    hand->limits[hal_axis_x] = by_hand(p->x_jog_um_per_s, p->x_speed_um_per_s,
                                       gentle[hal_axis_x].acceleration_q10, n, tick_hz);
    hand->limits[hal_axis_z] = by_hand(p->z_jog_um_per_s, p->z_speed_um_per_s,
                                       gentle[hal_axis_z].acceleration_q10, n, tick_hz);
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        hand->limits[i].log2_window = gentle[i].log2_window;
    }
    // Braking by steps may lead an eighth of one beyond the target (cam_move_profile.h), and the
    // command of U runs ahead of it by k1 and what is learned of that.
    const int64_t ahead_q10 =
        (2 * (int64_t)hand->limits[hal_axis_u].speed_q10 / n * config->command.k1_q16) >> 16;
    const int64_t room_q10 = hand->limits[hal_axis_u].acceleration_q10 / 8 + 1024 +
                             cam_clamp_i64(ahead_q10, 0, cam_build_room_q10(config));
    const int64_t end_q10 = (int64_t)p->u_stroke_nm * 512 - room_q10;
    hand->u_end_q10 = cam_clamp_i64(end_q10, 0, INT64_MAX) / 1024 * 1024;
}

void cam_build_origin(cam_config_t *config, int32_t x_nm, int32_t z_nm)
{
    cam_play_config_t *c = &config->play;
    c->x_clear_q10 += (int64_t)x_nm * 1024;
    c->x_offset_q10 += (int64_t)x_nm * 1024;
    c->z_origin_nm = z_nm;
    c->z_low_nm = cam_sat_i32((int64_t)c->z_low_nm + z_nm);
    c->z_high_nm = cam_sat_i32((int64_t)c->z_high_nm + z_nm);
}
