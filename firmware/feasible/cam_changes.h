// SPDX-License-Identifier: Apache-2.0
/// cam_changes: converts what the operator changes during a cut to values per plan.
///
/// The plan ramps the overrides of feed and spindle and the trim of X: the feed by the ramps of
/// cam_feed_motion.h, the others by a step from plan to plan.
/// Source: MATHS.md (175), (178), (179). Context: slow side.
#ifndef CAM_CHANGES_H
#define CAM_CHANGES_H

#include "cam_config.h" // cam_play_config_t
#include "cam_param.h"  // cam_params_t
#include <stdint.h>     // int32_t, uint32_t

/// @return [1e-6] override of the feed in force: a smaller one than a hundredth counts as 0 and
///         holds the feed; always 1 for a measured Z
int32_t cam_changes_feed_ppm(const cam_params_t *params);

/// @param c  complete except for the operator's changes, which are filled in
void cam_changes_build(cam_play_config_t *c, const cam_params_t *params, uint32_t tick_hz);

#endif
