// SPDX-License-Identifier: Apache-2.0
#include "cam_feasible_inner.h"
#include "hal/hal.h" // hal_force, hal_takes_force

/// Mass x square of the tick rate, 10^9 / 128, up to which motion_q24 of cam_build_force.c exceeds
/// its word.
enum { most_light_g_hz2 = 7812500 };

/// @return the parameter that a refusal of the design means
static cam_param_id_t refused_param(cam_servo_refused_t refused)
{
    static const cam_param_id_t ids[] = {cam_n_params, cam_n_params, cam_param_u_scale_latency_ns,
#define PARAM_ID(name) cam_param_servo_##name,
                                         CAM_SERVO_SET(PARAM_ID)
#undef PARAM_ID
    };
    return ids[refused];
}

int64_t cam_servo_needed_mn(const cam_params_t *p)
{
    const int64_t by_mass_un = (int64_t)p->servo_mass_g * p->u_acceleration_mm_per_s2;
    const int64_t by_drag_nn = (int64_t)p->servo_drag_mn_s_per_m * p->u_speed_um_per_s;
    const int64_t by_spring_nn = (int64_t)p->servo_stiffness_n_per_m * p->u_stroke_nm / 2;
    return (by_mass_un + 999) / 1000 + (by_drag_nn + by_spring_nn + 999999) / 1000000 +
           p->servo_friction_mn;
}

static cam_refusal_t refusal_of(const cam_params_t *params, cam_param_id_t id)
{
    return cam_refusal_of(cam_err_servo, id, cam_param_get(params, id), 0);
}

cam_refusal_t cam_servo_setup(const cam_params_t *params, uint32_t tick_hz, cam_servo_config_t *cfg)
{
    *cfg = (cam_servo_config_t){0};
    if (!hal_takes_force() || params->servo_crossover_hz == 0) {
        return cam_refusal_none();
    }
    const cam_servo_params_t physical = {.step_hz = (int32_t)tick_hz,
                                         .scale_delay_ns = params->u_scale_latency_ns,
#define FIELD(name) .name = params->servo_##name,
                                         CAM_SERVO_SET(FIELD)
#undef FIELD
    };
    const cam_servo_refused_t by_design = cam_servo_design(&physical, cfg);
    if (by_design != cam_servo_refused_none) {
        return refusal_of(params, refused_param(by_design));
    }
    if (params->servo_force_delay_ns < (int64_t)hal_force().latency_ns) {
        // the delay includes the latency of the output
        return refusal_of(params, cam_param_servo_force_delay_ns);
    }
    if ((int64_t)tick_hz * tick_hz * params->servo_mass_g <= most_light_g_hz2) {
        return refusal_of(params, cam_param_servo_mass_g);
    }
    const int64_t needed_mn = cam_servo_needed_mn(params);
    if (needed_mn > params->servo_force_limit_mn) {
        return cam_refusal_of(cam_err_servo_force, cam_param_servo_force_limit_mn, needed_mn,
                              params->servo_force_limit_mn);
    }
    return cam_refusal_none();
}
