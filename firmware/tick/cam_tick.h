// SPDX-License-Identifier: Apache-2.0
/// cam_tick: the interrupt, once per tick.
///
///     sense -> [force of U] -> observe -> play -> command -> guard -> actuate -> [plan] -> publish
///
/// Every n-th tick runs the plan (cam_plan.h). Only sense reads from the HAL, and only actuate
/// writes to it, with one exception: where U takes forces, its position loop runs right after sense
/// on the last tick's command, because each microsecond between the latch of the scale and
/// the force costs stiffness (cam_force.h). The tick owns the set-points (cam_motion_t): play
/// advances them, command makes axis commands of them, the guard accepts these or brakes U, and the
/// plan writes their increments. All state is one struct: a test can run several controllers.
#ifndef CAM_TICK_H
#define CAM_TICK_H

#include "cam_acknowledge.h" // cam_acknowledge_t
#include "cam_config.h"      // cam_config_bank_t
#include "cam_force.h"       // cam_force_t
#include "cam_guard.h"       // cam_guard_t
#include "cam_jog.h"         // cam_jog_t
#include "cam_turn_bins.h"   // cam_turn_bins_t
#include "cam_plan.h"        // cam_plan_t
#include "cam_play.h"        // cam_play_t
#include "cam_record.h"      // cam_motion_t, cam_tick_record_t
#include "cam_spindle.h"     // cam_spindle_t
#include "cam_trace.h"       // cam_trace_t
#include <stdatomic.h>       // request
#include <stdint.h>          // int32_t, int64_t, uint32_t

/// The controller as the interrupt sees it.
typedef struct {
    // interrupt writes
    cam_spindle_t spindle;
    cam_play_t play;
    cam_guard_t guard;
    cam_force_t force;   ///< where U takes forces
    cam_motion_t motion; ///< set-points and their increments
    cam_plan_t plan;
    cam_jog_t jog;
    cam_acknowledge_t acknowledge;
    int32_t until_plan; ///< [ticks] to the next plan, that tick included
    // interrupt reads
    _Atomic uint32_t request; ///< serial number << 8 | cam_request_t
    cam_config_bank_t config; ///< slow side writes the half that is not in use
    // both sides
    cam_turn_bins_t bins; ///< cam_turn_bins.h
    cam_trace_t trace;    ///< interrupt writes, slow side reads
} cam_t;

/// The controller that cam_isr() ticks.
extern cam_t g_cam;

/// One tick. Context: ISR; constant time with and without plan, bounded loops, no division or lock.
void cam_tick_isr(cam_t *c);

/// The stages between sense and actuate, and the plan, without the HAL: replays a recorded tick.
/// @param cfg  configuration of the tick
/// @param r    tick number and inputs; everything else is written
/// Context: a replay of a trace.
void cam_tick_steps_isr(cam_t *c, const cam_config_t *cfg, cam_tick_record_t *r);

#endif
