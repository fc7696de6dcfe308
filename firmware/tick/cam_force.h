// SPDX-License-Identifier: Apache-2.0
/// cam_force: the force of a U that takes forces, and its supervision.
///
/// The position loop (cam_servo.h) runs right after the readings on what the last tick commanded:
/// set-point, speed, acceleration and enable. Its set-point is looked up ahead by lead_ns, which
/// for such a drive is one tick plus servo_force_delay_ns: then it is due when the force acts.
///
/// An observer follows U as a mass with spring and drag under the force that was written. It has
/// both poles at 300 Hz: an unknown force d keeps it d / (mass (2 pi 300 Hz)^2) away, 19 um at 100
/// N and 1.5 kg.
///
///     u_runaway   U deviates from its observer by more than servo_runaway_nm: its force is
///                 reversed, it is blocked or pushed. Or its reading stands, to the last digit,
///                 for half a millisecond under a force that would deviate it by a quarter of
///                 that and move it by a step of the scale and back, twice the friction apart: the
///                 scale is frozen. The enable drops at once.
///     u_travel    U is beyond its stroke by more than its accepted following error, or too fast to
///                 stop before that with half its force; or a limit switch is on, in manual only if
///                 U moves towards it. The enable drops at once: before this U's set-point has
///                 braked within the stroke, so the loop does not work.
///     u_force     the force was at its limit for servo_limited_ms more than below it, for instance
///                 at the continuous force of a hot motor. U retracts.
///
/// While U is homed by its stop, its force is limited to u_home_force_mn, and u_runaway and u_force
/// are not checked: pressing on a stop looks like both.
///
/// Source: MATHS.md (238). Context: ISR, constant time.
#ifndef CAM_FORCE_H
#define CAM_FORCE_H

#include "cam_config.h" // cam_force_config_t
#include "cam_record.h" // cam_tick_record_t, cam_motion_t
#include "cam_servo.h"  // cam_servo_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t, int64_t, uint32_t

/// State; zero-initialised: off.
typedef struct {
    bool is_on;         ///< the drives were enabled in the last step
    cam_servo_t servo;  ///< position loop
    int64_t pos_q24;    ///< [nm / 2^24] observer, in port coordinates
    int64_t vel_q24;    ///< [nm / 2^24 per tick] observer
    int32_t still_nm;   ///< [nm] last reading
    uint32_t n_still;   ///< [ticks] for which it has stood under force
    uint32_t n_limited; ///< [ticks] at the limit minus those below it, at least 0
} cam_force_t;

/// Calculate the force.
/// @param r      inputs of the tick; r->force_q6 is the result
/// @param is_on  the last tick left the drives enabled; if not, the force is 0
/// @param m      last command of U, speed and acceleration of its set-point; in identifying also
///               the wave's force
void cam_force_step_isr(cam_force_t *f, const cam_force_config_t *cfg, cam_tick_record_t *r,
                        bool is_on, const cam_motion_t *m);

/// Supervise U.
/// @param r  with the force of this tick
/// @return   faults u_travel, u_runaway, u_force or none
uint32_t cam_force_watch_isr(cam_force_t *f, const cam_force_config_t *cfg,
                             const cam_tick_record_t *r, const cam_motion_t *m);

#endif
