// SPDX-License-Identifier: Apache-2.0
// One position loop for Python: drive_plant.py.
#include "cam_feasible_inner.h"

#define EXPORTED __attribute__((visibility("default")))

static cam_servo_config_t config;
static cam_servo_t servo;

static cam_params_t params;

/// Set a parameter of the loop. @return cam_err_t
EXPORTED int32_t servo_set(const char *name, int32_t value)
{
    return (int32_t)cam_param_set(&params, cam_param_find(name), value);
}

/// Make the loop and start it at rest at 0. @return whether the parameters are good
EXPORTED bool servo_open(int32_t step_hz)
{
    const cam_servo_input_t rest = {.set_q6 = 0};
    servo = (cam_servo_t){0};
    const bool is_good = cam_servo_design(&params, step_hz, &config) == cam_n_params;
    cam_servo_start_isr(&servo, &config, &rest);
    return is_good;
}

/// @return [mN / 64]
EXPORTED int32_t servo_step(int32_t set_q6, int32_t vel_q10, int32_t acc_q10, int32_t actual_q6)
{
    const cam_servo_input_t in = {
        .set_q6 = set_q6, .vel_q10 = vel_q10, .acc_q10 = acc_q10, .actual_q6 = actual_q6};
    return cam_servo_step_isr(&servo, &config, &in);
}
