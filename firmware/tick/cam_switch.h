// SPDX-License-Identifier: Apache-2.0
/// cam_switch: position switches, outputs that are on in a window of angle and height.
///
/// Each of the eight outputs has a window of the drawing's angle, repeated per_turn times per turn,
/// and a window of the height. Switching leads by the dead time of the actuator, at any speed and
/// in both directions, MATHS.md (180):
///     on where (n (angle + speed * (dead time + half a tick)) - from) mod 1 < width
/// so the output changes in the tick nearest to the edge of the window. After a change it keeps its
/// state until the spindle has moved away by the hysteresis, in either direction: a spindle that
/// dithers on an edge causes no chatter, and one that keeps turning switches exactly at the edges.
///
/// The angle is checked in every tick. Height, direction and lead change slowly: each tick updates
/// those of one output, in turn. Without a known angle, in off and in fault all outputs are off. An
/// output with a window of the height is on only in the work, because there is no height elsewhere.
/// Context: ISR.
#ifndef CAM_SWITCH_H
#define CAM_SWITCH_H

#include "cam_config.h" // cam_switches_config_t
#include "cam_record.h" // cam_tick_record_t
#include <stdint.h>     // uint32_t

/// State; zero-initialised: all off.
typedef struct {
    uint32_t on;                        ///< bit i: output i is on
    uint32_t open;                      ///< bit i: height, state and direction allow output i
    uint32_t held;                      ///< bit i: within the hysteresis of its last change
    uint32_t next;                      ///< output to be updated in the next tick
    uint32_t begin_q32[cam_n_switches]; ///< per_turn times the angle, plus this, is 0 at the begin
                                        ///< of the window
    uint32_t left_q32[cam_n_switches];  ///< [turn / 2^32] angle of the last change
} cam_switches_t;

/// One tick in which at least one output is in use.
/// @param r  record of the tick, after the guard
/// @return   hal_out_switch_1 and the seven bits above it
/// Constant time, except while an output changes or has just changed.
uint32_t cam_switches_step_isr(cam_switches_t *s, const cam_switches_config_t *cfg,
                               const cam_tick_record_t *r);

#endif
