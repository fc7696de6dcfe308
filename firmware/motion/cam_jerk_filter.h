// SPDX-License-Identifier: Apache-2.0
/// cam_jerk_filter: moves an axis to a position within speed, acceleration and jerk.
///
/// The set-point is the moving average of the last n set-points of a motion without jerk limit
/// (cam_move_profile.h). An average is never faster and never accelerates more than its input, so
/// those limits still hold; the acceleration changes by at most 2 a / n per step, and the axis
/// rests exactly at the same position, n steps later.
///
///     raw speed    ___/``\___           speed    __/``\__           jerk <= 2 a / n
///                   cam_move_profile            mean of the last n
///
/// A filtered motion may begin at speed, for example in the tick of a fault. Its earlier speeds are
/// then assumed to follow a straight line with the initial speed and acceleration. They are
/// calculated one by one as they leave the window, which needs no loop.
/// Source: MATHS.md (210), (211). Context: ISR, constant time, cannot fail.
#ifndef CAM_JERK_FILTER_H
#define CAM_JERK_FILTER_H

#include "cam_move_profile.h" // cam_axis_motion_t, cam_motion_limits_t
#include <stdbool.h>          // bool
#include <stdint.h>           // int32_t, int64_t, uint32_t

enum { cam_jerk_filter_most_log2 = 6 }; ///< n is a power of two, at most 64

/// State, made by cam_jerk_filter_begin_isr(). Zero-initialised it rests at 0.
typedef struct {
    cam_axis_motion_t raw;       ///< the motion before the filter
    int64_t sum_pos_q10;         ///< of the last n positions of raw
    int64_t sum_vel_q10;         ///< ... of its speeds
    int32_t line_q10, slope_q10; ///< next speed of the line to leave; its change
    uint32_t n_line;             ///< speeds of the line still in the window
    uint32_t n_still;            ///< steps since raw rests at its target, at most n
    uint32_t log2_window;        ///< n = 2^this
    uint32_t at;                 ///< steps, wraps
    int32_t past_q10[1 << cam_jerk_filter_most_log2]; ///< raw speeds of the last n steps
} cam_jerk_filter_t;

/// @return [nm / 1024 per step^2] largest initial acceleration for a window, so that the change of
/// speed over the window fits a word; a larger one is limited to it
static inline int32_t cam_jerk_filter_most_q10(uint32_t log2_window)
{
    return (INT32_C(1) << 30) >> log2_window;
}

/// Begin at the position, speed and acceleration of an axis.
/// @param m            the axis after its last step
/// @param log2_window  0 .. cam_jerk_filter_most_log2
void cam_jerk_filter_begin_isr(cam_jerk_filter_t *g, const cam_axis_motion_t *m,
                               uint32_t log2_window);

/// One step towards a target. Overshoots by at most acceleration_q10 / 8 unless the initial speed
/// makes more unavoidable.
/// @param m       the axis after its last step; then after this one
/// @param limits  a changed window takes effect at the next rest
/// @return        true when the axis rests at the target
bool cam_jerk_filter_to_isr(cam_jerk_filter_t *g, cam_axis_motion_t *m,
                            const cam_motion_limits_t *limits, int64_t target_q10);

/// One step of braking to rest.
/// @return true when the axis rests
bool cam_jerk_filter_stop_isr(cam_jerk_filter_t *g, cam_axis_motion_t *m,
                              const cam_motion_limits_t *limits);

/// Shift the origin of the axis from the next step on.
void cam_jerk_filter_shift_isr(cam_jerk_filter_t *g, int64_t by_q10);

#endif
