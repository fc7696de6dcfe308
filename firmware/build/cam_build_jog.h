// SPDX-License-Identifier: Apache-2.0
/// cam_build_jog: what a configuration needs of the hands: limits of axes that are moved by hand,
/// and where the part lies on the machine.
///
/// Context: slow side.
#ifndef CAM_BUILD_JOG_H
#define CAM_BUILD_JOG_H

#include "cam_config.h" // cam_config_t
#include "cam_param.h"  // cam_params_t
#include <stdint.h>     // int32_t, uint32_t

/// Derive the limits by hand; a part of cam_build_config(), behind the limits of the approach.
void cam_build_jog(cam_config_t *config, const cam_params_t *params, uint32_t tick_hz);

/// Move the part to where it lies on the machine. Targets move, axes do not: set-points stay the
/// numbers of the port. Source: MATHS.md (170).
/// @param config      of cam_build_config(), once
/// @param x_nm, z_nm  [nm] where the port counts X and Z at radius 0 and height 0 of the part
void cam_build_origin(cam_config_t *config, int32_t x_nm, int32_t z_nm);

#endif
