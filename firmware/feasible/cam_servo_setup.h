// SPDX-License-Identifier: Apache-2.0
/// cam_servo_setup: the parameters servo_* as a position loop of U.
/// Context: slow side.
#ifndef CAM_SERVO_SETUP_H
#define CAM_SERVO_SETUP_H

#include "cam_err.h"     // CAM_MUST_USE
#include "cam_param.h"   // cam_params_t
#include "cam_refusal.h" // cam_refusal_t
#include "cam_servo.h"   // cam_servo_config_t
#include <stdint.h>      // uint32_t

/// Check the parameters, and calculate the coefficients. Nothing is checked while the port takes
/// positions for U or servo_crossover_hz is 0.
/// @param cfg  result; all 0 where nothing is checked
/// @return     cam_ok, cam_err_servo (also where the delay of the force is less than the latency of
///             the port's output, or the mass too light for the supervision at this rate), or
///             cam_err_servo_force where U's limits need more than the force limit [mN]
CAM_MUST_USE cam_refusal_t cam_servo_setup(const cam_params_t *params, uint32_t tick_hz,
                                           cam_servo_config_t *cfg);

/// @return [mN] force that U needs for mass, drag, friction and stiffness at the limits of its
///         acceleration, speed and stroke together; rounded up
int64_t cam_servo_needed_mn(const cam_params_t *params);

#endif
