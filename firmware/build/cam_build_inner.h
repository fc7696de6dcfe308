// SPDX-License-Identifier: Apache-2.0
/// cam_build_inner: parts of cam_build_config(), private to this room. Context: slow side.
#ifndef CAM_BUILD_INNER_H
#define CAM_BUILD_INNER_H

#include "cam_config.h"  // cam_config_t
#include "cam_err.h"     // CAM_MUST_USE
#include "cam_param.h"   // cam_params_t
#include "cam_refusal.h" // cam_refusal_t
#include <stdint.h>      // int32_t, int64_t, uint32_t

/// [nm / 1024] Rounding margin of set-point checks, which also allow 1/16 for encoder noise.
#define CAM_BUILD_MARGIN_Q10 3072

/// Derive the limits of all axes with their jerk windows: approach, retract and axis commands.
/// Requires the gains of the feed-forward, the spindle and the feed.
void cam_build_motion(cam_config_t *config, const cam_params_t *params, uint32_t tick_hz);

/// Derive the limits of jogging. Call after cam_build_motion().
void cam_build_jog(cam_config_t *config, const cam_params_t *params, uint32_t tick_hz);

/// Derive the position loop of a U that takes forces, and its supervision without the travel.
/// @return as cam_servo_setup()
CAM_MUST_USE cam_refusal_t cam_build_force(cam_force_config_t *c, const cam_params_t *params,
                                           uint32_t tick_hz);

#endif
