// SPDX-License-Identifier: Apache-2.0
#include "cam_feasible_inner.h"
#include "cam_doubles.h" // CAM_PI, cam_nearest, cam_root
#include "cam_fix.h"     // cam_is_between
#include "hal/hal.h"     // hal_force, hal_takes_force
#include <stdbool.h>     // bool

/// @return the first parameter that is out of its bounds by others; cam_n_params: none
static cam_param_id_t out_of_bounds(const cam_params_t *p, int32_t step_hz)
{
    const struct {
        bool is_within;
        cam_param_id_t which;
    } bounds[] = {
        {p->servo_pole_hz <= step_hz / 5, cam_param_servo_pole_hz},
        {p->servo_crossover_hz <= p->servo_pole_hz, cam_param_servo_crossover_hz},
        {p->servo_integral_mHz <= p->servo_crossover_hz * 1000, cam_param_servo_integral_mHz},
        {p->servo_notch_hz == 0 || cam_is_between(p->servo_notch_hz, step_hz / 1000, step_hz / 4),
         cam_param_servo_notch_hz},
        {p->servo_notch_zero_permille <= p->servo_notch_pole_permille,
         cam_param_servo_notch_zero_permille},
        {(int64_t)(p->u_scale_latency_ns + p->servo_force_delay_ns) * step_hz <=
             INT64_C(16000000000),
         cam_param_servo_force_delay_ns},
        {p->servo_force_limit_mn <= p->servo_continuous_mn * cam_servo_most_overload,
         cam_param_servo_force_limit_mn},
    };
    for (uint32_t i = 0; i < sizeof bounds / sizeof bounds[0]; i++) {
        if (!bounds[i].is_within) {
            return bounds[i].which;
        }
    }
    return cam_n_params;
}

/// K of MATHS.md (234), by the magnitude of the lead at the crossover. @return [N/um]
static double gain(const cam_params_t *p)
{
    const double omega = 2.0 * CAM_PI * p->servo_crossover_hz;
    const double lag = (double)p->servo_crossover_hz / p->servo_pole_hz;
    const double lead = p->servo_lead_percent / 100.0 * lag;
    return omega * omega * p->servo_mass_g * 1e-9 *
           cam_root((1.0 + lag * lag) / (1.0 + lead * lead));
}

/// PI with lead, MATHS.md (234), and feed-forward, (236).
/// @return the parameter whose coefficient exceeds its word; cam_n_params: none
static cam_param_id_t make_coefficients(const cam_params_t *p, int32_t step_hz,
                                        cam_servo_config_t *c)
{
    const double hz = step_hz;
    const double k = gain(p);
    const double more = (p->servo_lead_percent - 100) / 100.0;
    const double corner_hz = p->servo_integral_mHz / 1000.0;
    const double by_pole = corner_hz / p->servo_pole_hz;
    const double x = CAM_PI * p->servo_pole_hz / hz;
    const double half_ki = k * CAM_PI * corner_hz / hz;
    const double kp = k * (1.0 + by_pole * more) - half_ki;
    const double kd = k * more * (1.0 - by_pole) / (1.0 + x);
    const struct {
        int32_t *word;
        double value; // 0 or more
        cam_param_id_t which;
    } coefficients[] = {
        {&c->ki_q32, half_ki * 0x1p33, cam_param_servo_integral_mHz},
        {&c->kp_q18, kp * 0x1p18, cam_param_servo_mass_g},
        {&c->kd_q18, kd * 0x1p18, cam_param_servo_lead_percent},
        {&c->mass_q14, p->servo_mass_g * 1e-9 * hz * hz * 0x1p14, cam_param_servo_mass_g},
        {&c->drag_q14, p->servo_drag_mn_s_per_m * 1e-9 * hz * 0x1p14,
         cam_param_servo_drag_mn_s_per_m},
        {&c->stiffness_q18, p->servo_stiffness_n_per_m * 1e-6 * 0x1p18,
         cam_param_servo_stiffness_n_per_m},
    };
    c->pole_q18 = cam_nearest((1.0 - x) / (1.0 + x) * 0x1p18);
    for (uint32_t i = 0; i < sizeof coefficients / sizeof coefficients[0]; i++) {
        *coefficients[i].word = cam_nearest(coefficients[i].value);
        if (*coefficients[i].word > cam_servo_most_gain) {
            return coefficients[i].which;
        }
    }
    return cam_n_params;
}

/// MATHS.md (235), with tan by its continued fraction.
static cam_servo_notch_t notch(const cam_params_t *p, int32_t step_hz)
{
    if (p->servo_notch_hz == 0) {
        return (cam_servo_notch_t){.b0_q30 = 1 << 30};
    }
    const double x = CAM_PI * p->servo_notch_hz / step_hz;
    const double x2 = x * x;
    const double t = x * (105.0 - 10.0 * x2) / (105.0 - 45.0 * x2 + x2 * x2);
    const double base = 1.0 + t * t;
    const double pole = p->servo_notch_pole_permille * t / 500.0;
    const double zero = p->servo_notch_zero_permille * t / 500.0;
    const int32_t b0_q30 = cam_nearest((base + zero) / (base + pole) * 0x1p30);
    const int32_t minus_a2_q30 = cam_nearest((pole - base) / (base + pole) * 0x1p30);
    return (cam_servo_notch_t){.b0_q30 = b0_q30,
                               .b1_q30 = cam_nearest(2.0 * (t * t - 1.0) / (base + pole) * 0x1p30),
                               .b2_q30 = (1 << 30) - b0_q30 - minus_a2_q30,
                               .minus_a2_q30 = minus_a2_q30};
}

/// Limits, MATHS.md (237), and the instant of the set-point, (233).
static void make_limits(const cam_params_t *p, int32_t step_hz, cam_servo_config_t *c)
{
    const int64_t rate_q6 = (int64_t)p->servo_force_rate_n_per_ms * 64000000 / step_hz;
    const int64_t ahead_ns = (int64_t)p->u_scale_latency_ns + p->servo_force_delay_ns;
    c->friction_q12 = p->servo_friction_mn * 4096;
    c->limit_q6 = p->servo_force_limit_mn * 64;
    c->continuous_q6 =
        64 * (int32_t)cam_smaller_i64(p->servo_continuous_mn, p->servo_force_limit_mn);
    c->per_continuous = (int32_t)((INT64_C(1) << 43) / c->continuous_q6);
    c->rate_q6 = (int32_t)cam_smaller_i64(rate_q6, INT64_C(1) << 29);
    c->cooling_q32 = (int32_t)(INT64_C(4294967296000) / ((int64_t)p->servo_thermal_ms * step_hz));
    const int64_t steps_q16 = -((ahead_ns * step_hz * 4096 + 31250000) / 62500000);
    c->ahead = (cam_servo_ahead_t){.steps_q16 = (int32_t)steps_q16,
                                   .half_square_q16 = (int32_t)(steps_q16 * steps_q16 / 131072),
                                   .third_q28 = (int32_t)(steps_q16 * 4096 / 3)};
}

cam_param_id_t cam_servo_design(const cam_params_t *p, int32_t step_hz, cam_servo_config_t *cfg)
{
    *cfg = (cam_servo_config_t){.notch = {.b0_q30 = 1 << 30}};
    const cam_param_id_t refused = out_of_bounds(p, step_hz);
    if (refused != cam_n_params) {
        return refused;
    }
    cfg->notch = notch(p, step_hz);
    make_limits(p, step_hz, cfg);
    return make_coefficients(p, step_hz, cfg);
}

/// Mass x square of the tick rate, 10^9 / 128, up to which motion_q24 of cam_build_force.c exceeds
/// its word.
enum { most_light_g_hz2 = 7812500 };

int64_t cam_servo_needed_mn(const cam_params_t *p)
{
    const int64_t by_mass_un = (int64_t)p->servo_mass_g * p->u_acceleration_mm_per_s2;
    const int64_t by_drag_nn = (int64_t)p->servo_drag_mn_s_per_m * p->u_speed_um_per_s;
    const int64_t by_spring_nn = (int64_t)p->servo_stiffness_n_per_m * p->u_stroke_nm / 2;
    return (by_mass_un + 999) / 1000 + (by_drag_nn + by_spring_nn + 999999) / 1000000 +
           p->servo_friction_mn;
}

/// @return a parameter that makes no loop; cam_n_params: none
static cam_param_id_t unfit(const cam_params_t *p, uint32_t tick_hz, cam_servo_config_t *cfg)
{
    const cam_param_id_t by_design = cam_servo_design(p, (int32_t)tick_hz, cfg);
    if (by_design != cam_n_params) {
        return by_design;
    }
    if (p->servo_force_delay_ns < (int64_t)hal_force().latency_ns) { // which is a part of it
        return cam_param_servo_force_delay_ns;
    }
    const bool is_light = (int64_t)tick_hz * tick_hz * p->servo_mass_g <= most_light_g_hz2;
    return is_light ? cam_param_servo_mass_g : cam_n_params;
}

cam_refusal_t cam_servo_setup(const cam_params_t *params, uint32_t tick_hz, cam_servo_config_t *cfg)
{
    *cfg = (cam_servo_config_t){0};
    if (!hal_takes_force() || params->servo_crossover_hz == 0) {
        return cam_refusal_none();
    }
    const cam_param_id_t id = unfit(params, tick_hz, cfg);
    if (id != cam_n_params) {
        return cam_refusal_of(cam_err_servo, id, cam_param_get(params, id), 0);
    }
    const int64_t needed_mn = cam_servo_needed_mn(params);
    return needed_mn > params->servo_force_limit_mn
               ? cam_refusal_of(cam_err_servo_force, cam_param_servo_force_limit_mn, needed_mn,
                                params->servo_force_limit_mn)
               : cam_refusal_none();
}
