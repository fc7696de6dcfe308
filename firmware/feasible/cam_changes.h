// SPDX-License-Identifier: Apache-2.0
/// cam_changes: converts the operator's changes during a cut to numbers per plan.
///
/// Overrides of feed and spindle, and the trim of X. Each is ramped by the plan: the feed by the
/// ramps of its course (cam_feed_motion.h), the others by a step from plan to plan.
/// Source: MATHS.md (175), (178), (179). Context: slow side.
#ifndef CAM_CHANGES_H
#define CAM_CHANGES_H

#include "cam_config.h" // cam_play_config_t
#include "cam_param.h"  // cam_params_t
#include <stdint.h>     // int32_t, uint32_t

/// [1e-6] A smaller override of the feed holds it, so that the reciprocal fits its word.
enum { cam_changes_least_feed_ppm = 10000 };

/// @return [1e-6] override of the feed in force: 0, or at least a hundredth; 1 for a measured Z
int32_t cam_changes_feed_ppm(const cam_params_t *params);

/// Fill in the operator's changes.
/// @param c  complete except for these
void cam_changes_build(cam_play_config_t *c, const cam_params_t *params, uint32_t tick_hz);

#endif
