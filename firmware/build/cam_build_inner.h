// SPDX-License-Identifier: Apache-2.0
/// cam_build_inner: the part of the configuration that holds a U that takes forces, private to this
/// room. Context of all functions: slow side.
#ifndef CAM_BUILD_INNER_H
#define CAM_BUILD_INNER_H

#include "cam_build.h"  // cam_config_t, cam_params_t, cam_refusal_t
#include "cam_config.h" // cam_force_config_t
#include <stdint.h>     // uint32_t

/// Build the position loop of U and its supervision, without what cam_build_force_limits() adds.
/// @return refusals of cam_servo_setup()
CAM_MUST_USE cam_refusal_t cam_build_force(cam_force_config_t *c, const cam_params_t *p,
                                           uint32_t tick_hz);

/// Add what follows from guard and approach: the travel of U, and how fast it may be pushed out.
void cam_build_force_limits(cam_config_t *config, const cam_params_t *params);

#endif
