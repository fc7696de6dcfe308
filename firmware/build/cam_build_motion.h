// SPDX-License-Identifier: Apache-2.0
/// cam_build_motion: the part of cam_build.h that makes limits of motions by time, and of what the
/// axes are told.
///
/// Context: slow side.
#ifndef CAM_BUILD_MOTION_H
#define CAM_BUILD_MOTION_H

#include "cam_config.h" // cam_config_t
#include "cam_param.h"  // cam_params_t
#include <stdint.h>     // int64_t, uint32_t

/// Set-point checks allow 1/16 over the limits for encoder noise, and three nanometres of rounding.
#define CAM_BUILD_MARGIN_Q10 3072

/// Derive the limits of all axes, with their windows: of approaches and of the retract, and of what
/// X and Z are told. The gains of the feed-forward, the spindle and the feed are known.
void cam_build_motion(cam_config_t *config, const cam_params_t *params, uint32_t tick_hz);

/// The end of a retract may take the command of U beyond its target: by an eighth of the
/// acceleration because it brakes tick by tick (cam_move_profile.c), and by what the feed-forward
/// is then ahead of the way that is left, MATHS.md (214).
/// @return [nm / 1024]
int64_t cam_build_room_q10(const cam_config_t *config);

#endif
