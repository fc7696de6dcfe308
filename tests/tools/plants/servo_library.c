// SPDX-License-Identifier: Apache-2.0
// One position loop for Python: drive_plant.py.
#include "cam_feasible_inner.h"
#include <string.h> // memcpy

#define EXPORTED __attribute__((visibility("default")))

static cam_servo_config_t config;
static cam_servo_t servo;

/// @return names of the parameters, in their order
EXPORTED const char *servo_fields(void)
{
#define NAME(name) #name " "
    return CAM_SERVO_PARAMS(NAME);
#undef NAME
}

/// Make the loop and start it at rest at 0. @return the parameter that is refused, counted from 1
EXPORTED int32_t servo_open(const int32_t *values)
{
    cam_servo_params_t params;
    memcpy(&params, values, sizeof params);
    const cam_servo_refused_t refused = cam_servo_design(&params, &config);
    const cam_servo_input_t rest = {.set_q6 = 0};
    servo = (cam_servo_t){0};
    cam_servo_start_isr(&servo, &config, &rest);
    return (int32_t)refused;
}

/// @return [mN / 64]
EXPORTED int32_t servo_step(int32_t set_q6, int32_t vel_q10, int32_t acc_q10, int32_t actual_q6)
{
    const cam_servo_input_t in = {
        .set_q6 = set_q6, .vel_q10 = vel_q10, .acc_q10 = acc_q10, .actual_q6 = actual_q6};
    return cam_servo_step_isr(&servo, &config, &in);
}
