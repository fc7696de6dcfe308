// SPDX-License-Identifier: Apache-2.0
/// cam_positioning: plans all axes while they do not follow the table.
///
/// In homing, ready, identifying, the approach to a cut, and fault, X and Z move to positions or
/// brake within their limits, one step per plan; a measured Z is followed, and the swing returns to
/// 0. U gets a target, to which the ticks move it (cam_play.h); in fault the guard retracts U. In
/// off the swing follows its scale (the other axes: cam_play.h). The end of homing is decided here.
#ifndef CAM_POSITIONING_H
#define CAM_POSITIONING_H

#include "cam_config.h" // cam_play_config_t
#include "cam_record.h" // cam_tick_record_t, cam_motion_t
#include <stdbool.h>    // bool

/// One plan outside the cut.
/// @param m  increments, replaced from the next tick on
/// @return   true in the states rehearsing and engaging when all axes are at their start
/// Context: ISR, called by cam_plan_isr(); constant time in each state.
bool cam_positioning_isr(const cam_play_config_t *cfg, const cam_tick_record_t *r, cam_motion_t *m);

#endif
