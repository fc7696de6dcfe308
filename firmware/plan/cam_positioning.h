// SPDX-License-Identifier: Apache-2.0
/// cam_positioning: the plan of all axes while they do not follow the table.
///
/// Off, homing, ready, the approach to a cut, and the state fault. X and Z move to places, or brake
/// to rest, within their limits by one step per plan; U has its target, to which every tick leads
/// it (cam_play.h), and in the state fault the guard retracts it.
#ifndef CAM_POSITIONING_H
#define CAM_POSITIONING_H

#include "cam_config.h" // cam_play_config_t
#include "cam_record.h" // cam_tick_record_t, cam_motion_t
#include <stdbool.h>    // bool

/// One plan out of the cut.
/// @param r  record of the tick
/// @param m  increments up to now, replaced by those from the next tick on
/// @return   true in the states rehearsing and engaging when all axes are where they begin
/// Context: ISR, called by cam_plan_isr(); constant time in each state.
bool cam_positioning_isr(const cam_play_config_t *cfg, const cam_tick_record_t *r, cam_motion_t *m);

#endif
