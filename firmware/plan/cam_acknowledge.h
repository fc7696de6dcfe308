// SPDX-License-Identifier: Apache-2.0
/// cam_acknowledge: nothing moves again before somebody at the machine has pressed a button.
///
/// After power-on, the emergency stop or a fault the drives are enabled (enable, home, manual) only
/// when the input acknowledge has had a press: released for a while, pressed for 0.05 to 2 s,
/// released. All of it happens in the state off with the emergency-stop chain closed, so that a
/// press before the reset or before the chain was closed is none. A stuck button is pressed too
/// long, and of one that bounces only what is stable for 20 ms counts. A press is good for 60 s of
/// the state off: an enable must come within them, and after a disable another one within 60 s.
///
///     needed --released 50 ms--> armed --pressed--> pressed --released, 50 ms .. 2 s--> given
///                                  ^---- too short ----'                                  |
///     needed <------------------------ pressed too long, or 60 s --------------------------
///     given --enable, manual--> used --off--> given
///     any --fault, chain open, even for one tick--> needed
///
/// The interrupt judges it, in the plan, and refuses by itself; the slow side only explains.
/// Context: ISR unless noted; constant time.
#ifndef CAM_ACKNOWLEDGE_H
#define CAM_ACKNOWLEDGE_H

#include "cam_config.h" // cam_acknowledge_config_t
#include "cam_record.h" // cam_motion_t, cam_tick_record_t
#include <stdbool.h>    // bool
#include <stdint.h>     // uint32_t

typedef enum {
    cam_acknowledge_needed,  ///< nothing counts before the button is released
    cam_acknowledge_armed,   ///< it is released, a press counts
    cam_acknowledge_pressed, ///< it is pressed
    cam_acknowledge_given,   ///< it was pressed; enable must come
    cam_acknowledge_used,    ///< enable has come
} cam_acknowledge_phase_t;

/// State; zero-initialised is that of power-on.
typedef struct {
    cam_acknowledge_phase_t phase;
    bool is_pressed;  ///< the input without its bouncing
    uint32_t n_other; ///< [plans] that the input has been otherwise
    uint32_t n_plans; ///< [plans] since is_pressed or the phase changed
} cam_acknowledge_t;

/// Look at the button, once per plan. Writes whether the drives may be enabled into the motion.
void cam_acknowledge_isr(cam_acknowledge_t *a, const cam_acknowledge_config_t *cfg,
                         const cam_tick_record_t *r, cam_motion_t *m);

/// @return [plans] that are left for enable; 0 unless the phase is given. Context: slow side.
uint32_t cam_acknowledge_left(const cam_acknowledge_t *a, const cam_acknowledge_config_t *cfg);

#endif
