// SPDX-License-Identifier: Apache-2.0
/// cam_modulate: the tasks of cam_plan.h that read the speed ratio of the table and make of it what
/// the spindle is told, in the order of the list there, twice in a round.
///
/// Each hands its result to the next in p->plan, returns no fault and takes a constant time.
/// Context: ISR, called by cam_plan_task_isr() only.
#ifndef CAM_MODULATE_H
#define CAM_MODULATE_H

#include "cam_play.h"    // cam_play_t, cam_play_config_t
#include "cam_spindle.h" // cam_angle_t
#include "cam_state.h"   // CAM_STAGE
#include <stdint.h>      // uint32_t

/// Where on the channel: the angle, and the place between two of its slices.
CAM_STAGE uint32_t cam_modulate_find_slices_isr(cam_play_t *p, const cam_play_config_t *cfg,
                                                const cam_angle_t *angle);

/// The knots around that angle.
CAM_STAGE uint32_t cam_modulate_find_ratio_isr(cam_play_t *p, const cam_play_config_t *cfg);

/// @param end  0: the knot before the place, 1: the one behind it
CAM_STAGE uint32_t cam_modulate_read_knot_isr(cam_play_t *p, uint32_t end);

/// The quintic between them.
CAM_STAGE uint32_t cam_modulate_read_ratio_isr(cam_play_t *p);

/// Value and slope as a ratio of the mean speed.
CAM_STAGE uint32_t cam_modulate_scale_ratio_isr(cam_play_t *p, const cam_play_config_t *cfg);

/// The ratio with the envelope of the cut: 1 outside of it.
CAM_STAGE uint32_t cam_modulate_pace_isr(cam_play_t *p);

/// What a spindle with that lag must be told for it.
CAM_STAGE uint32_t cam_modulate_told_isr(cam_play_t *p, const cam_play_config_t *cfg);

/// ... in r/min: the set-point from this tick on.
CAM_STAGE uint32_t cam_modulate_speed_isr(cam_play_t *p, const cam_play_config_t *cfg);

/// The acceleration that the spindle was told, for the observer.
CAM_STAGE uint32_t cam_modulate_alpha_isr(cam_play_t *p, const cam_play_config_t *cfg);

/// ... and in the unit of U's, for its feed-forward.
CAM_STAGE uint32_t cam_modulate_alpha_u_isr(cam_play_t *p, const cam_play_config_t *cfg);

#endif
