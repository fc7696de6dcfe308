// SPDX-License-Identifier: Apache-2.0
/// cam_switch: position switches, outputs that are on in windows of angle and height.
///
/// Each of the eight outputs has one window of the drawing's angle, repeated per_turn times per
/// turn, and one of the height. An output whose actuator takes a time to act is switched that much
/// ahead, at any speed and in both senses of rotation:
///     on where (n (angle + speed * (dead time + half a tick)) - from) mod 1 < width  MATHS.md
///     (180)
/// so that a change comes in the tick that is nearest to the end of the window.
/// Behind a change an output stays as it is until the spindle has left the place of the change by
/// the hysteresis, in either sense, so that a spindle that trembles on an edge does not make it
/// chatter; a spindle that goes on switches at the edges exactly.
///
/// The angle is looked at in every tick. Height, sense of rotation and the angle of the dead time
/// change slowly: in every tick those of one output are brought up to date, in turn. Without a
/// known angle, in off and in fault all outputs are off; an output with a window of the height is
/// on in the work only, because no height is played elsewhere.
/// Context: ISR.
#ifndef CAM_SWITCH_H
#define CAM_SWITCH_H

#include "cam_config.h" // cam_switches_config_t
#include "cam_record.h" // cam_tick_record_t
#include <stdint.h>     // uint32_t

/// State; zero-initialised is: all off.
typedef struct {
    uint32_t on;   ///< bit i: output i is on
    uint32_t open; ///< bit i: height, state and sense let output i be on
    uint32_t held; ///< bit i: near the place of its last change, which it keeps
    uint32_t next; ///< output that is brought up to date in the next tick
    uint32_t begin_q32[cam_n_switches]; ///< what n times the angle is behind the window's begin by
    uint32_t left_q32[cam_n_switches];  ///< [turn / 2^32] place of the last change
} cam_switches_t;

/// One tick in which at least one output is in use.
/// @param r  record of the tick, behind the guard
/// @return   hal_out_switch_1 and the seven bits above it
/// Constant time but for the ticks in which an output changes or has just changed.
uint32_t cam_switches_step_isr(cam_switches_t *s, const cam_switches_config_t *cfg,
                               const cam_tick_record_t *r);

#endif
