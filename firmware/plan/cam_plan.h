// SPDX-License-Identifier: Apache-2.0
/// cam_plan: what changes slowly in a cut, planned ahead every n-th tick.
///
/// n = max(1, round(cam_plan_period_us * tick rate)): 8 ticks at 20 kHz, every tick at 1 kHz. A
/// plan reads the record of its tick and writes the increments (cam_motion_t) that are in force
/// from the next tick to that of the next plan: heights and envelopes, X and Z, U's amplitude and
/// height, the swing, the speed of the spindle, the state, and the faults that need no exact tick
/// (z_range, swing). It plans for the instant of the next plan, so that X, Z and U's envelope move
/// linearly from plan to plan and arrive exactly; in between they are off the true course by at
/// most its second derivative times T^2 / 8, T the period of the plan.
///
/// It is the last step of its tick, behind the writes: the outputs of a tick never wait for it, and
/// what it plans has the whole period to take effect. A replay runs it in the same place.
/// Context: ISR unless noted.
#ifndef CAM_PLAN_H
#define CAM_PLAN_H

#include "cam_config.h"      // cam_play_config_t
#include "cam_feed_motion.h" // cam_feed_motion_t
#include "cam_record.h"      // cam_tick_record_t, cam_motion_t
#include "cam_shaft.h"       // cam_shaft_t
#include <stdbool.h>         // bool
#include <stdint.h>          // int32_t, int64_t

/// Chosen by measurement: README.md, "Two rates".
enum { cam_plan_period_us = 400 };

/// State; zero-initialised is before the first cut.
typedef struct {
    int64_t engage_at_q32;         ///< [turn] master position where the envelope starts to rise
    int64_t feed_at_q32;           ///< ... where Z starts
    int64_t disengage_at_q32;      ///< ... where the envelope starts to fall
    int32_t measured_nm;           ///< [nm] Z of the last plan
    int32_t amplitude_q30;         ///< [1] ramped
    int32_t ratio_q28;             ///< [1] speed ratio at the end of the last plan
    int32_t x_trim_q4;             ///< [nm / 16] ramped
    int32_t spindle_rate_q30;      ///< [1] override of the spindle, ramped
    bool is_rehearsal;             ///< what is laid is the rehearsal of a cut
    bool is_stopped;               ///< ... and nothing follows it
    cam_feed_motion_t feed_motion; ///< of the feed
    cam_shaft_t shaft;             ///< lobe that is played
} cam_plan_t;

/// One plan.
/// @param r  record of the tick, with everything but the plan done
/// @param m  increments up to now, replaced by those from the next tick on
/// Constant time in each state.
void cam_plan_isr(cam_plan_t *p, const cam_play_config_t *cfg, const cam_tick_record_t *r,
                  cam_motion_t *m);

/// @return [ticks] from plan to plan, at least 1. Context: slow side.
static inline int32_t cam_plan_ticks(uint32_t tick_hz)
{
    const uint32_t ticks = (tick_hz * (uint32_t)cam_plan_period_us + 500000u) / 1000000u;
    return ticks > 1u ? (int32_t)ticks : 1;
}

#endif
