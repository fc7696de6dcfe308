// SPDX-License-Identifier: Apache-2.0
/// cam_jog: jog, step and homing: the plan of the state manual.
///
/// One axis follows the order of the configuration (cam_config.h), all others brake and stop.
/// When an order ends, is stopped or expires, its axis brakes gently. Expiry is checked here, by
/// the tick, so an axis stops even if the slow side hangs, MATHS.md (171).
///
/// Homing, MATHS.md (172):
///
///     here                                                  home is the present position
///     search --switch--> release --no switch--> done        home is where it left the switch, or
///                                --> index --index--> done  the first index after that
///
/// If the axis is already on the switch, homing begins with release. A phase that finds nothing
/// within the travel of the order ends it without a home. U, whose travel is its stroke: the search
/// first sets U's position to an end of its stroke, and the home finally sets it to its value.
///
/// A U that takes forces may have a stop instead of a switch, MATHS.md (173). The stop is found,
/// and is the home, when the force is at the limit of the order and U has stood within 1 um for 20
/// ms. U has left it when it is 10 um back and within its stroke. The force stays limited until a
/// home is found or the drives are disabled, because an order that ends earlier may leave U on its
/// stop.
#ifndef CAM_JOG_H
#define CAM_JOG_H

#include "cam_config.h" // cam_jog_phase_t, cam_play_config_t
#include "cam_record.h" // cam_tick_record_t, cam_motion_t
#include "hal/hal.h"    // hal_axis_t
#include <stdint.h>     // int32_t, uint32_t

/// State; zero-initialised: no order, nothing homed.
typedef struct {
    uint32_t serial; ///< of the last order begun
    cam_jog_phase_t phase;
    cam_jog_end_t end; ///< of that order
    hal_axis_t axis;
    int64_t target_q10;           ///< [nm / 1024] where the phase ends
    int32_t stood_nm;             ///< [nm] U at its stop, or when it last moved
    uint32_t n_still;             ///< [plans] for which it has stood there since
    uint32_t homed;               ///< bit of an axis: its home is known
    uint32_t n_found;             ///< homes found since start
    int32_t found_nm[hal_n_axes]; ///< [nm] port position of the axis at its home
} cam_jog_t;

/// One plan of the state manual; ends the state when a disable was requested and all axes rest.
/// @param m  increments, replaced from the next tick on; U's origin shifted
/// Context: ISR; constant time in each phase.
void cam_jog_isr(cam_jog_t *h, const cam_play_config_t *cfg, const cam_tick_record_t *r,
                 cam_motion_t *m);

/// One plan of any other state: orders are discarded, and homes are forgotten while the drives are
/// not ready. Context: ISR, constant time.
void cam_jog_idle_isr(cam_jog_t *h, const cam_play_config_t *cfg, const cam_tick_record_t *r);

#endif
