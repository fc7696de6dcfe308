// SPDX-License-Identifier: Apache-2.0
/// cam_plan_move: X or Z moves by one step per plan, within limits per plan.
///
/// What cam_jerk_filter.h does from tick to tick is done here from plan to plan, and the increments
/// of the axis carry the step out in equal shares. A motion begins with the speed that the axis
/// has, and with the change of its speed in the last plan, as far as that is within its limits.
/// Context: ISR, constant time, cannot fail.
#ifndef CAM_PLAN_MOVE_H
#define CAM_PLAN_MOVE_H

#include "cam_config.h"       // cam_play_config_t
#include "cam_move_profile.h" // cam_motion_limits_t
#include "cam_record.h"       // cam_motion_t
#include <stdbool.h>          // bool
#include <stdint.h>           // int64_t

/// Move an axis towards a place.
/// @param limits  [nm / 1024 per plan, per plan^2]
/// @return        true when it rests there
bool cam_plan_move_to_isr(cam_motion_t *m, hal_axis_t axis, const cam_play_config_t *cfg,
                          const cam_motion_limits_t *limits, int64_t place_q10);

/// Brake an axis to rest, wherever that is.
/// @param limits  [nm / 1024 per plan, per plan^2]
/// @return        true when it rests
bool cam_plan_move_brake_isr(cam_motion_t *m, hal_axis_t axis, const cam_play_config_t *cfg,
                             const cam_motion_limits_t *limits);

#endif
