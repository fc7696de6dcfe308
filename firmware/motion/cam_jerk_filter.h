// SPDX-License-Identifier: Apache-2.0
/// cam_jerk_filter: bring an axis to a place within speed, acceleration and jerk.
///
/// The set-point is the mean of the last n set-points of a motion without a limit of jerk
/// (cam_move_profile.h). A mean is never faster and never accelerates more than what it is taken
/// of, so the limits of speed and acceleration hold by themselves; the acceleration changes by at
/// most 2 a / n per step, and the axis comes to rest on the same place n steps later, exactly.
///
///     raw speed    ___/``\___           speed    __/``\__           jerk <= 2 a / n
///                   cam_move_profile            mean of the last n
///
/// A glide may begin in motion, for example in the tick of a fault. Then the speeds before it are
/// taken for those of the straight line that has the speed and the acceleration of the begin. They
/// are calculated one by one as they leave the window, so that no loop fills a memory.
/// Source: MATHS.md (210), (211). Context: ISR, constant time, cannot fail.
#ifndef CAM_JERK_FILTER_H
#define CAM_JERK_FILTER_H

#include "cam_move_profile.h" // cam_axis_motion_t, cam_motion_limits_t
#include <stdbool.h>          // bool
#include <stdint.h>           // int32_t, int64_t, uint32_t

enum { cam_jerk_filter_most_log2 = 6 }; ///< n is a power of two, at most 64

/// State, made by cam_jerk_filter_begin_isr(). Zero-initialised it rests at 0.
typedef struct {
    cam_axis_motion_t raw;       ///< the motion whose mean is taken
    int64_t sum_pos_q10;         ///< of the last n places of raw
    int64_t sum_vel_q10;         ///< ... of its speeds
    int32_t line_q10, slope_q10; ///< speed of the line that leaves next; its change
    uint32_t n_line;             ///< speeds of the line that are still in the window
    uint32_t n_still;            ///< steps since raw rests on its target, at most n
    uint32_t log2_window;        ///< n = 2^this
    uint32_t at;                 ///< steps, wraps
    int32_t past_q10[1 << cam_jerk_filter_most_log2]; ///< raw speeds of the last n steps
} cam_jerk_filter_t;

/// @return [nm / 1024 per step^2] the largest acceleration for a window: what the speed changes by
/// over it fits a word together with the speed. A larger one of a begin is taken for this
static inline int32_t cam_jerk_filter_most_q10(uint32_t log2_window)
{
    return (INT32_C(1) << 30) >> log2_window;
}

/// Begin where an axis is, at its speed and acceleration.
/// @param m            the axis; speed and acceleration are those of its last step
/// @param log2_window  0 .. cam_jerk_filter_most_log2
void cam_jerk_filter_begin_isr(cam_jerk_filter_t *g, const cam_axis_motion_t *m,
                               uint32_t log2_window);

/// One step towards a target. Passes it by at most acceleration_q10 / 8 unless the speed of the
/// begin makes more unavoidable.
/// @param m       the axis, where the last step left it; its place, speed and acceleration of this
///                step
/// @param limits  a window that differs from that of the begin counts from the next rest on
/// @return        true when the axis rests on the target
bool cam_jerk_filter_to_isr(cam_jerk_filter_t *g, cam_axis_motion_t *m,
                            const cam_motion_limits_t *limits, int64_t target_q10);

/// One step of braking to rest, wherever that is.
/// @return true when the axis rests
bool cam_jerk_filter_stop_isr(cam_jerk_filter_t *g, cam_axis_motion_t *m,
                              const cam_motion_limits_t *limits);

/// The axis is called by other numbers from the next step on.
void cam_jerk_filter_shift_isr(cam_jerk_filter_t *g, int64_t by_q10);

#endif
