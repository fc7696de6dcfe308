// SPDX-License-Identifier: Apache-2.0
/// cam_servo_design: the coefficients of the position loop from physical quantities.
///
/// The loop crosses over where a free mass without lag would: |C| m wc^2 = 1. Delay, amplifier and
/// modes move the real crossover; margins are the caller's concern (tools/camtools/tune).
/// Coefficients are rounded to nearest: relative errors below 2^-27 plus half a unit of the last
/// place (cam_servo_config_t gives the units). Source: MATHS.md (233) .. (237).
/// Context: slow side, integers only.
#ifndef CAM_SERVO_DESIGN_H
#define CAM_SERVO_DESIGN_H

#include "cam_err.h"   // CAM_MUST_USE
#include "cam_servo.h" // cam_servo_config_t
#include <stdint.h>    // int32_t

// clang-format off
/// X(name, least, most): physical quantities and their ranges.
#define CAM_SERVO_PARAMS(X) \
    X(step_hz,                1000,    200000) /* rate of the loop */ \
    X(mass_g,                   10,    100000) /* moving mass, of loop and feed-forward */ \
    X(crossover_hz,              1,      5000) /* at most pole_hz */ \
    X(lead_percent,            100,     20000) /* pole over zero of the lead */ \
    X(pole_hz,                  10,     40000) /* of the lead; at most step_hz / 5 */ \
    X(integral_mhz,              0,   1000000) /* corner of PI; at most crossover_hz */ \
    X(notch_hz,                  0,     50000) /* 0: none; step_hz / 1000 .. step_hz / 4 */ \
    X(notch_zero_permille,       0,      2000) /* damping of its zeros; at most that of its poles */ \
    X(notch_pole_permille,       1,      2000) /* damping of its poles */ \
    X(scale_delay_ns,            0,    200000) /* age of a reading */ \
    X(force_delay_ns,            0,    500000) /* whole delay of the force, its hold included */ \
    X(drag_mn_s_per_m,           0,  10000000) /* of the feed-forward, as the next two */ \
    X(friction_mn,               0,    200000) \
    X(stiffness_n_per_m,         0, 100000000) \
    X(force_limit_mn,          200,   4000000) /* at most 15 times the continuous force */ \
    X(force_rate_n_per_ms,       1,   1000000) /* change of the force */ \
    X(continuous_mn,           200,   4000000) /* force that is allowed for ever */ \
    X(thermal_ms,              100,    200000) /* thermal time constant */
// clang-format on

typedef struct {
#define CAM_SERVO_FIELD(name, least, most) int32_t name; ///< least .. most
    CAM_SERVO_PARAMS(CAM_SERVO_FIELD)
#undef CAM_SERVO_FIELD
} cam_servo_params_t;

/// Parameter that cam_servo_design() refuses.
typedef enum {
    cam_servo_refused_none,
#define CAM_SERVO_NUMBER(name, least, most) cam_servo_refused_##name,
    CAM_SERVO_PARAMS(CAM_SERVO_NUMBER)
#undef CAM_SERVO_NUMBER
} cam_servo_refused_t;

/// Calculate the coefficients. Its `ahead` is for a set-point that is due when the force acts:
/// force_delay_ns after the latch of the step.
/// @param cfg  result, unspecified after a refusal
/// @return     first parameter that is out of its range or beyond its bound by another one, or
///             mass_g, lead_percent, integral_mhz, drag_mn_s_per_m .. if its coefficient overflows
CAM_MUST_USE cam_servo_refused_t cam_servo_design(const cam_servo_params_t *p,
                                                  cam_servo_config_t *cfg);

/// @return name of a parameter as above, "none" for none
const char *cam_servo_refused_name(cam_servo_refused_t which);

#endif
