// SPDX-License-Identifier: Apache-2.0
/// cam_acknowledge: nothing moves before somebody presses a button at the machine.
///
/// After power-on, an emergency stop or a fault the drives can be enabled (enable, home, manual)
/// only after a press of the input acknowledge: released for a while, pressed for 0.05 to 2 s,
/// released, all in the state off with the emergency-stop chain closed. Earlier presses do not
/// count. A stuck button is pressed too long; levels count when stable for 20 ms. Enable must
/// follow within 60 s, and after each disable again within 60 s.
///
///     needed --released 50 ms--> armed --pressed--> pressed --released, 50 ms .. 2 s--> given
///                                  ^---- too short ----'                                  |
///     needed <------------------------ pressed too long, or 60 s --------------------------
///     given --enable, manual--> used --off--> given
///     any --fault, chain open, even for one tick--> needed
///
/// The plan checks the button, so the interrupt refuses by itself; the slow side only explains.
/// Context: ISR unless noted; constant time.
#ifndef CAM_ACKNOWLEDGE_H
#define CAM_ACKNOWLEDGE_H

#include "cam_config.h" // cam_acknowledge_config_t
#include "cam_record.h" // cam_motion_t, cam_tick_record_t
#include <stdbool.h>    // bool
#include <stdint.h>     // uint32_t

typedef enum {
    cam_acknowledge_needed,  ///< the button must be released first
    cam_acknowledge_armed,   ///< released, waiting for the press
    cam_acknowledge_pressed, ///< pressed
    cam_acknowledge_given,   ///< pressed and released; waiting for enable
    cam_acknowledge_used,    ///< enabled
} cam_acknowledge_phase_t;

/// State; zero-initialised: power-on.
typedef struct {
    cam_acknowledge_phase_t phase;
    bool is_pressed;  ///< debounced input
    uint32_t n_other; ///< [plans] for which the input has differed from it
    uint32_t n_plans; ///< [plans] since is_pressed or the phase changed
} cam_acknowledge_t;

/// Check the button, once per plan. Writes m->is_acknowledged.
void cam_acknowledge_isr(cam_acknowledge_t *a, const cam_acknowledge_config_t *cfg,
                         const cam_tick_record_t *r, cam_motion_t *m);

/// @return [plans] left for enable; 0 unless the phase is given. Context: slow side.
uint32_t cam_acknowledge_left(const cam_acknowledge_t *a, const cam_acknowledge_config_t *cfg);

#endif
