// SPDX-License-Identifier: Apache-2.0
/// cam_move_profile: moves an axis to a position within speed and acceleration, tick by tick.
///
/// Used, with the jerk limit of cam_jerk_filter.h, wherever an axis does not follow the spindle:
/// approach, retract, stop after a fault; without it for the gain of a wave (cam_excite.h). No
/// square root, no division: a step is accepted if the axis can still brake to the target, MATHS.md
/// (60). Positions are nm / 1024 (q10), speeds nm / 1024 per tick.
/// Context: ISR, constant time.
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

/// A moving set-point.
typedef struct {
    int64_t pos_q10;
    int32_t vel_q10;
    int32_t acc_q10; ///< [nm / 1024 per tick^2] of the last step
} cam_axis_motion_t;

/// One tick towards a target. Speed stays within the limit (after braking, if it starts beyond) and
/// its change within the acceleration. Overshoots by at most acceleration_q10 / 8 unless the
/// initial speed makes more unavoidable.
/// @return true when the axis rests at the target
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

/// One tick of braking to rest.
/// @return true when the axis rests
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
