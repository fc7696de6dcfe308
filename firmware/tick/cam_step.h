// SPDX-License-Identifier: Apache-2.0
/// cam_step: an axis moves by one step per plan, within limits per plan.
///
/// What cam_move.h does from tick to tick is done here from plan to plan, and the increments of the
/// axis carry the step out in equal shares. Context: ISR, constant time, cannot fail.
#ifndef CAM_STEP_H
#define CAM_STEP_H

#include "cam_config.h" // cam_play_config_t
#include "cam_move.h"   // cam_move_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int64_t

/// Move an axis towards a place.
/// @param limits  [nm / 1024 per plan, per plan^2]
/// @return        true when it rests there
bool cam_step_to_isr(cam_move_t *m, const cam_play_config_t *cfg, const cam_move_limits_t *limits,
                     int64_t place_q10);

/// Brake an axis to rest, wherever that is.
/// @param limits  [nm / 1024 per plan, per plan^2]
/// @return        true when it rests
bool cam_step_brake_isr(cam_move_t *m, const cam_play_config_t *cfg,
                        const cam_move_limits_t *limits);

#endif
