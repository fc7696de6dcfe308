// SPDX-License-Identifier: Apache-2.0
/// cam_move_profile: bring an axis to a place within speed and acceleration limits, tick by tick.
///
/// What cam_jerk_filter.h rounds off, wherever an axis does not follow the spindle: approach,
/// retract, stop after a fault; and by itself the gain of a wave (cam_excite.h). No square root, no
/// division: a step is accepted when the axis could still brake to the target, MATHS.md (60). Unit
/// of positions: nm / 1024 (q10); of speeds: nm / 1024 per tick.
#ifndef CAM_MOVE_PROFILE_H
#define CAM_MOVE_PROFILE_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, int64_t

/// Limits of an axis.
typedef struct {
    int32_t speed_q10;        ///< [nm / 1024 per tick] > 0
    int32_t acceleration_q10; ///< [nm / 1024 per tick^2] > 0
    uint32_t log2_window; ///< 0 .. cam_jerk_filter_most_log2, for cam_jerk_filter.h: 2^this ticks
                          ///< share a change of acceleration
} cam_motion_limits_t;

/// A set-point in motion.
typedef struct {
    int64_t pos_q10;
    int32_t vel_q10;
    int32_t acc_q10; ///< [nm / 1024 per tick^2] of the last step
} cam_axis_motion_t;

/// One tick towards a target; speed within limits (after braking, when it starts beyond), change of
/// speed within the acceleration; passes the target by at most acceleration_q10 / 8 unless the
/// start speed makes more unavoidable.
/// @return true when the axis rests on the target
/// Context: ISR, constant time.
/*@ requires valid: \valid(m) && \valid_read(limits) && \separated(m, limits);
    requires limits: 0 <= limits->speed_q10 <= 0x40000000 &&
      0 <= limits->acceleration_q10 <= 0x40000000;
    assigns *m, \result \from *m, *limits, target_q10;
    behavior usual:
      assumes \abs(m->vel_q10) <= 0x3FFFFFFF;
      assumes \abs(m->pos_q10) <= 0x1000000000000000 && \abs(target_q10) <= 0x1000000000000000;
      ensures most: \abs(m->vel_q10) <=
        \max(limits->speed_q10, \abs(\old(m->vel_q10)) - limits->acceleration_q10);
      ensures change: \abs(m->vel_q10 - \old(m->vel_q10)) <= limits->acceleration_q10;
      ensures acceleration: m->acc_q10 == m->vel_q10 - \old(m->vel_q10);
      ensures step: m->pos_q10 == \old(m->pos_q10) + m->vel_q10;
      ensures there: \result <==> m->pos_q10 == target_q10 && m->vel_q10 == 0;
*/
bool cam_move_profile_to_isr(cam_axis_motion_t *m, const cam_motion_limits_t *limits,
                             int64_t target_q10);

/// One tick of braking to rest, wherever that is.
/// @return true when the axis rests
/// Context: ISR, constant time.
/*@ requires valid: \valid(m) && \valid_read(limits) && \separated(m, limits);
    requires limits: 0 <= limits->acceleration_q10 <= 0x40000000;
    assigns *m, \result \from *m, *limits;
    ensures slower: \abs(m->vel_q10) ==
      \max(0, \abs(\old(m->vel_q10)) - limits->acceleration_q10);
    ensures change: \abs(m->vel_q10 - \old(m->vel_q10)) <= limits->acceleration_q10;
    ensures acceleration: m->acc_q10 == m->vel_q10 - \old(m->vel_q10);
    ensures rest: \result <==> m->vel_q10 == 0;
    behavior usual:
      assumes \abs(m->pos_q10) <= 0x1000000000000000;
      ensures step: m->pos_q10 == \old(m->pos_q10) + m->vel_q10;
*/
bool cam_move_profile_stop_isr(cam_axis_motion_t *m, const cam_motion_limits_t *limits);

#endif
