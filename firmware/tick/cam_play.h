// SPDX-License-Identifier: Apache-2.0
/// cam_play: from master position to set-points of all axes, in every tick.
///
/// While the table plays (rehearsing and engaging once the axes have arrived, cutting, holding,
/// disengaging) every axis is a function of the spindle angle:
///     U = amplitude * envelope * u(angle + speed * lead - phase, Z)
///     Z = first height + feed * turns since feed start   eased in and out (or measured, or along
///         the ring-helix of cam_feed.h)
///     X = x(Z) + trim + (1 - envelope) * clearance       (trim: x_trim_nm and the pass's stock)
///     spindle = mean speed, or mean * (1 + envelope * (ratio(angle, Z) - 1)) where the table
///               modulates it (cam_speed.h)
/// U is evaluated in every tick, at the angle the spindle will have after the drive's dead time.
/// Everything else changes slowly and advances by the increments of the plan (cam_plan.h).
/// Otherwise U moves to a target within its limits (cam_jerk_filter.h), which the plan sets, and
/// the plan moves X and Z; while identifying, a wave is added to U (cam_excite.h). In off U follows
/// its scale, in fault the guard moves it. A request takes effect in the tick that reads it; the
/// plan schedules the stop of a cut.
/// Source: MATHS.md (54), (55). Context: ISR.
#ifndef CAM_PLAY_H
#define CAM_PLAY_H

#include "cam_config.h" // cam_play_config_t
#include "cam_excite.h" // cam_excite_t
#include "cam_record.h" // cam_tick_record_t, cam_motion_t
#include <stdint.h>     // uint32_t

/// State; zero-initialised: no request carried out.
typedef struct {
    uint32_t request;    ///< serial number of the last one carried out
    cam_excite_t excite; ///< in the state identifying
} cam_play_t;

/// One tick of the sequence, constant time in each state.
/// @param cfg  with a table, unless the state is off or fault
/// @param r    inputs, request and spindle; r->want is the result, without faults and outputs
/// @param m    set-points, advanced by one tick
void cam_play_step_isr(cam_play_t *p, const cam_play_config_t *cfg, cam_tick_record_t *r,
                       cam_motion_t *m);

#endif
