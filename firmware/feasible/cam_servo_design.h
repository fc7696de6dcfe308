// SPDX-License-Identifier: Apache-2.0
/// cam_servo_design: the coefficients of the position loop from physical quantities.
///
/// The loop crosses over where a free mass without lag would: |C| m wc^2 = 1. Delay, amplifier and
/// modes move the real crossover; margins are the caller's concern (tools/camtools/tune).
/// Coefficients are rounded to nearest, within a unit of the last place (cam_servo_config_t gives
/// the units). Source: MATHS.md (233) .. (237). Context: slow side, in doubles (cam_doubles.h).
#ifndef CAM_SERVO_DESIGN_H
#define CAM_SERVO_DESIGN_H

#include "cam_err.h"   // CAM_MUST_USE
#include "cam_servo.h" // cam_servo_config_t
#include <stdint.h>    // int32_t

/// X(name) of each physical quantity. Their ranges are those of the parameters servo_* of
/// cam_param.h; step_hz is 500 .. 200 000 and scale_delay_ns 0 .. 200 000.
#define CAM_SERVO_PARAMS(X)                                                                        \
    X(step_hz)        /* rate of the loop */                                                       \
    X(scale_delay_ns) /* age of a reading */                                                       \
    CAM_SERVO_SET(X)

/// Those that are set for a drive.
#define CAM_SERVO_SET(X)                                                                           \
    X(mass_g)              /* moving mass, of loop and feed-forward */                             \
    X(crossover_hz)        /* 1 .. pole_hz */                                                      \
    X(lead_percent)        /* pole over zero of the lead */                                        \
    X(pole_hz)             /* of the lead; at most step_hz / 5 */                                  \
    X(integral_mHz)        /* corner of PI; at most crossover_hz */                                \
    X(notch_hz)            /* 0: none; step_hz / 1000 .. step_hz / 4 */                            \
    X(notch_zero_permille) /* damping of its zeros; at most that of its poles */                   \
    X(notch_pole_permille) /* damping of its poles */                                              \
    X(force_delay_ns)      /* whole delay of the force, its hold included */                       \
    X(drag_mn_s_per_m)     /* of the feed-forward, as the next two */                              \
    X(friction_mn)                                                                                 \
    X(stiffness_n_per_m)                                                                           \
    X(force_limit_mn)      /* at most 15 times the continuous force */                             \
    X(force_rate_n_per_ms) /* change of the force */                                               \
    X(continuous_mn) /* force that is allowed for ever; more than the limit counts as the limit */ \
    X(thermal_ms)    /* thermal time constant */

typedef struct {
#define CAM_SERVO_FIELD(name) int32_t name; ///< in its range
    CAM_SERVO_PARAMS(CAM_SERVO_FIELD)
#undef CAM_SERVO_FIELD
} cam_servo_params_t;

/// Parameter that cam_servo_design() refuses.
typedef enum {
    cam_servo_refused_none,
#define CAM_SERVO_NUMBER(name) cam_servo_refused_##name,
    CAM_SERVO_PARAMS(CAM_SERVO_NUMBER)
#undef CAM_SERVO_NUMBER
} cam_servo_refused_t;

/// Calculate the coefficients. Its `ahead` is for a set-point that is due when the force acts:
/// force_delay_ns after the latch of the step.
/// @param cfg  result, unspecified after a refusal
/// @return     first parameter that is beyond its bound by another one, or
///             mass_g, lead_percent, integral_mHz, drag_mn_s_per_m .. if its coefficient overflows
CAM_MUST_USE cam_servo_refused_t cam_servo_design(const cam_servo_params_t *p,
                                                  cam_servo_config_t *cfg);

#endif
