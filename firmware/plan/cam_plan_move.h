// SPDX-License-Identifier: Apache-2.0
/// cam_plan_move: moves X or Z by one step per plan, within limits per plan.
///
/// Runs cam_jerk_filter.h once per plan; the ticks interpolate linearly. A motion begins with the
/// present speed of the axis and the last change of its speed, within the limits.
/// Context: ISR, constant time, cannot fail.
#ifndef CAM_PLAN_MOVE_H
#define CAM_PLAN_MOVE_H

#include "cam_config.h"       // cam_play_config_t
#include "cam_move_profile.h" // cam_motion_limits_t
#include "cam_record.h"       // cam_motion_t
#include <stdbool.h>          // bool
#include <stdint.h>           // int64_t

/// Move an axis towards a position.
/// @param limits  [nm / 1024 per plan, per plan^2]
/// @return        true when it rests there
bool cam_plan_move_to_isr(cam_motion_t *m, hal_axis_t axis, const cam_play_config_t *cfg,
                          const cam_motion_limits_t *limits, int64_t position_q10);

/// Brake an axis to rest.
/// @param limits  [nm / 1024 per plan, per plan^2]
/// @return        true when it rests
bool cam_plan_move_brake_isr(cam_motion_t *m, hal_axis_t axis, const cam_play_config_t *cfg,
                             const cam_motion_limits_t *limits);

#endif
