// SPDX-License-Identifier: Apache-2.0
/// cam_gains: windows of timed moves, and limits of U's feed-forward gains.
///
/// A motion by time is the mean over a window (cam_jerk_filter.h), whose length follows from the
/// jerk of the axis, or where none is set from tick, limits and feed-forward. In the cut the
/// feed-forward adds k1 times the speed and k2 times the acceleration to the command of U, and so
/// the command itself moves with v + k1 a + k2 j. Gains that would add more than about U's highest
/// speed are refused.
/// Source: MATHS.md (212), (213). Context: slow side, integers only.
#ifndef CAM_GAINS_H
#define CAM_GAINS_H

#include "cam_param.h"   // cam_params_t, cam_param_id_t
#include "cam_refusal.h" // cam_refusal_t
#include "hal/hal.h"     // hal_axis_t
#include <stdint.h>      // int32_t, int64_t, uint32_t

/// @return log2 of an axis's window in ticks (U) or plans (X, Z), 0 .. cam_jerk_filter_most_log2
uint32_t cam_gains_log2_window(const cam_params_t *params, hal_axis_t axis, uint32_t tick_hz);

/// Find the largest k1_ns or k2_us2, or the least jerk above 0, that fits the other parameters.
/// @param id  cam_param_k1_ns, .._k2_us2, .._u_jerk_m_per_s3, x_.. or z_..
int64_t cam_gains_bound(const cam_params_t *params, cam_param_id_t id, uint32_t tick_hz);

/// Check jerks and gains.
/// @return cam_ok, cam_err_jerk with the least jerk or cam_err_gain with the largest gain
CAM_MUST_USE cam_refusal_t cam_gains_check(const cam_params_t *params, uint32_t tick_hz);

#endif
