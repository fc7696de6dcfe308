// SPDX-License-Identifier: Apache-2.0
#include "cam_motion.h"
#include "cam_fix.h" // cam_is_within

/// Braking by a per tick from v covers v (v - a) / 2a; with the tick at v itself v (v + a) / 2a.
//@ assigns \result \from vel, acceleration, distance;
static bool can_brake(uint32_t vel, uint32_t acceleration, uint32_t distance)
{
    const uint32_t sum = vel + acceleration;
    const uint32_t twice = 2u * acceleration;
    return (uint64_t)vel * sum <= (uint64_t)twice * distance;
}

/*@ requires limits: \valid_read(limits) && 0 <= limits->speed_q10 <= 0x40000000 &&
      0 <= limits->acceleration_q10 <= 0x40000000;
    assigns \result \from vel, *limits, distance;
    behavior usual:
      assumes \abs(vel) <= 0x3FFFFFFF;
      ensures change: vel - limits->acceleration_q10 <= \result <= vel + limits->acceleration_q10;
      ensures most: \result <= \max(limits->speed_q10, vel - limits->acceleration_q10);
      ensures back: \result >= \min(0, vel + limits->acceleration_q10);
*/
/// @return the highest of faster, same and slower speed that does not overshoot the target
static int32_t choose(int32_t vel, const cam_motion_limits_t *limits, uint32_t distance)
{
    const int32_t a = limits->acceleration_q10;
    const int32_t less = cam_sat_add(vel, -a);
    const int32_t more = cam_sat_add(vel, a);
    const int32_t slower = less > limits->speed_q10 ? less : limits->speed_q10;
    const int32_t faster = more <= limits->speed_q10 ? more : slower;
    if (faster <= 0 || can_brake((uint32_t)faster, (uint32_t)a, distance)) {
        return faster;
    }
    const int32_t same = vel > 0 ? vel : 0;
    if (same <= limits->speed_q10 && can_brake((uint32_t)same, (uint32_t)a, distance)) {
        return same;
    }
    return less > 0 ? less : 0;
}

bool cam_move_profile_to_isr(cam_axis_motion_t *m, const cam_motion_limits_t *limits,
                             int64_t target_q10)
{
    const int64_t distance = cam_wrap_sub_i64(target_q10, m->pos_q10);
    const bool is_backward = distance < 0;
    // A longer distance never limits the speed: the axis can always brake within it.
    const int32_t left = (int32_t)cam_clamp_i64(distance, -INT32_MAX, INT32_MAX);
    const int32_t ahead = is_backward ? -left : left;
    const int32_t vel = is_backward ? cam_sat_sub(0, m->vel_q10) : m->vel_q10;
    const int32_t a = limits->acceleration_q10;
    const bool is_near = ahead <= a && ahead <= limits->speed_q10;
    const bool is_last = is_near && cam_is_within(cam_sat_sub(ahead, vel), a);
    const int32_t next = is_last ? ahead : choose(vel, limits, (uint32_t)ahead);
    const int32_t vel_q10 = is_backward ? cam_sat_sub(0, next) : next;
    m->acc_q10 = cam_sat_sub(vel_q10, m->vel_q10);
    m->vel_q10 = vel_q10;
    m->pos_q10 = cam_wrap_add_i64(m->pos_q10, vel_q10);
    return m->pos_q10 == target_q10 && next == 0;
}

bool cam_move_profile_stop_isr(cam_axis_motion_t *m, const cam_motion_limits_t *limits)
{
    const int32_t a = limits->acceleration_q10;
    m->acc_q10 = -cam_clamp_i32(m->vel_q10, -a, a);
    m->vel_q10 = cam_sat_add(m->vel_q10, m->acc_q10);
    m->pos_q10 = cam_wrap_add_i64(m->pos_q10, m->vel_q10);
    return m->vel_q10 == 0;
}
