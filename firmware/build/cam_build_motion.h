// SPDX-License-Identifier: Apache-2.0
/// cam_build_motion: the part of cam_build.h for limits of motions over time: approach, retract,
/// axis commands and jogging; and for the offset of the part. Context: slow side.
#ifndef CAM_BUILD_MOTION_H
#define CAM_BUILD_MOTION_H

#include "cam_config.h" // cam_config_t
#include "cam_param.h"  // cam_params_t
#include <stdint.h>     // int32_t, int64_t, uint32_t

/// [nm / 1024] Rounding margin of set-point checks, which also allow 1/16 for encoder noise.
#define CAM_BUILD_MARGIN_Q10 3072

/// Derive the limits of all axes with their jerk windows. Requires the gains of the feed-forward,
/// the spindle and the feed.
void cam_build_motion(cam_config_t *config, const cam_params_t *params, uint32_t tick_hz);

/// @return [nm / 1024] by how much the end of a retract may take the command of U beyond its
///         target: an eighth of the acceleration, because it brakes in ticks (cam_move_profile.c),
///         and the lead of the feed-forward, MATHS.md (214)
int64_t cam_build_room_q10(const cam_config_t *config);

/// Derive the limits of jogging. Call after cam_build_motion().
void cam_build_jog(cam_config_t *config, const cam_params_t *params, uint32_t tick_hz);

/// Shift the targets in X and Z by the offset of the part; set-points stay in port coordinates.
/// Call once after cam_build_config(). Source: MATHS.md (170).
/// @param x_nm, z_nm  [nm] port coordinates of the part's origin
void cam_build_origin(cam_config_t *config, int32_t x_nm, int32_t z_nm);

#endif
