// SPDX-License-Identifier: Apache-2.0
/// cam_plan: plans ahead what changes slowly in a cut, every n-th tick.
///
/// n = max(1, round(cam_plan_period_us * tick rate)): 8 ticks at 20 kHz, every tick at 1 kHz. A
/// plan reads the record of its tick and writes the increments (cam_motion_t) used from the next
/// tick up to the next plan: heights and envelopes, X and Z, U's amplitude and height, the swing,
/// the speed of the spindle, the state, and the faults that may wait for a plan (z_range, swing).
/// It plans for the instant of the next plan, so X, Z and U's envelope move linearly from plan to
/// plan and are exact there; in between the error is at most their second derivative times T^2 / 8,
/// T the period of the plan.
///
/// The plan runs after the outputs of its tick are written, so they never wait for it.
/// Context: ISR unless noted.
#ifndef CAM_PLAN_H
#define CAM_PLAN_H

#include "cam_config.h"      // cam_play_config_t
#include "cam_feed_motion.h" // cam_feed_motion_t
#include "cam_record.h"      // cam_tick_record_t, cam_motion_t
#include "cam_shaft.h"       // cam_shaft_t
#include "cam_steady.h"      // cam_steady_t
#include <stdbool.h>         // bool
#include <stdint.h>          // int32_t, int64_t

/// Keeps the error between plans and the load small: README.md, "Two rates".
enum { cam_plan_period_us = 400 };

/// State; zero-initialised: before the first cut.
typedef struct {
    int64_t engage_at_q32;         ///< [turn] master position where the envelope starts to rise
    int64_t feed_at_q32;           ///< ... where Z starts
    int64_t disengage_at_q32;      ///< ... where the envelope starts to fall
    int32_t measured_nm;           ///< [nm] Z of the last plan
    int32_t amplitude_q30;         ///< [1] ramped
    int32_t ratio_q28;             ///< [1] speed ratio at the end of the last plan
    int32_t x_trim_q4;             ///< [nm / 16] ramped
    int32_t spindle_rate_q30;      ///< [1] override of the spindle, ramped
    bool is_rehearsal;             ///< a rehearsal is scheduled, not the cut
    bool is_stopped;               ///< stopped: no cut follows the rehearsal
    cam_feed_motion_t feed_motion; ///< feed of the cut
    cam_shaft_t shaft;             ///< current lobe
    cam_steady_t steady;           ///< wait for a steady spindle
} cam_plan_t;

/// One plan, constant time in each state.
/// @param r  record of the tick, complete
/// @param m  increments, replaced from the next tick on
void cam_plan_isr(cam_plan_t *p, const cam_play_config_t *cfg, const cam_tick_record_t *r,
                  cam_motion_t *m);

/// @return [ticks] from plan to plan, at least 1. Context: slow side.
static inline int32_t cam_plan_ticks(uint32_t tick_hz)
{
    const uint32_t ticks = (tick_hz * (uint32_t)cam_plan_period_us + 500000u) / 1000000u;
    return ticks > 1u ? (int32_t)ticks : 1;
}

#endif
