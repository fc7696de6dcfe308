// SPDX-License-Identifier: Apache-2.0
#include "cam/cam_move.h"
#include "cam/cam_fix.h" // cam_clamp_i32

/// Distances beyond this are as good as infinite for braking; keeps 2 a d within int64.
#define FAR_Q10 (INT64_C(1) << 31)

static bool step(cam_move_t *m, int32_t vel_q10)
{
    m->acc_q10 = vel_q10 - m->vel_q10;
    m->vel_q10 = vel_q10;
    m->pos_q10 += vel_q10;
    return vel_q10 == 0;
}

/// Braking by a per tick from v covers v (v - a) / 2a; with the tick at v itself v (v + a) / 2a.
static bool can_brake(int64_t vel, int64_t acceleration, int64_t distance)
{
    return vel * (vel + acceleration) <= 2 * acceleration * distance;
}

/// Highest of faster, same, slower speed from which the target is not overshot.
static int32_t choose(int32_t vel, const cam_move_limits_t *limits, int64_t distance)
{
    const int32_t a = limits->acceleration_q10;
    const int32_t faster = vel + a <= limits->speed_q10 ? vel + a
                           : vel > limits->speed_q10    ? vel - a
                                                        : limits->speed_q10;
    if (faster <= 0 || can_brake(faster, a, distance)) {
        return faster;
    }
    if (vel <= 0 || (vel <= limits->speed_q10 && can_brake(vel, a, distance))) {
        return vel > 0 ? vel : 0;
    }
    return vel - a > 0 ? vel - a : 0;
}

bool cam_move_to_isr(cam_move_t *m, const cam_move_limits_t *limits, int64_t target_q10)
{
    const int64_t distance = target_q10 - m->pos_q10;
    const bool is_backward = distance < 0;
    const int64_t ahead = cam_abs_i64(distance);
    const int32_t vel = is_backward ? -m->vel_q10 : m->vel_q10;
    const int32_t a = limits->acceleration_q10;
    const bool is_last = ahead <= a && cam_abs_i64(ahead - vel) <= a;
    const int32_t next =
        is_last ? (int32_t)ahead : choose(vel, limits, cam_clamp_i64(ahead, 0, FAR_Q10));
    (void)step(m, is_backward ? -next : next);
    return m->pos_q10 == target_q10 && next == 0;
}

bool cam_move_stop_isr(cam_move_t *m, const cam_move_limits_t *limits)
{
    const int32_t a = limits->acceleration_q10;
    return step(m, m->vel_q10 - cam_clamp_i32(m->vel_q10, -a, a));
}
