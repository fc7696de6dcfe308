// SPDX-License-Identifier: Apache-2.0
#include "cam_feasible_inner.h"
#include "cam_doubles.h" // CAM_PI, cam_nearest, cam_root
#include "cam_fix.h"     // cam_is_between
#include <stdbool.h>     // bool

/// Bounds of parameters by others.
static cam_servo_refused_t check_bounds(const cam_servo_params_t *p)
{
    const struct {
        bool is_within;
        cam_servo_refused_t which;
    } bounds[] = {
        {p->pole_hz <= p->step_hz / 5, cam_servo_refused_pole_hz},
        {p->crossover_hz <= p->pole_hz, cam_servo_refused_crossover_hz},
        {p->integral_mHz <= p->crossover_hz * 1000, cam_servo_refused_integral_mHz},
        {p->notch_hz == 0 || cam_is_between(p->notch_hz, p->step_hz / 1000, p->step_hz / 4),
         cam_servo_refused_notch_hz},
        {p->notch_zero_permille <= p->notch_pole_permille, cam_servo_refused_notch_zero_permille},
        {(int64_t)(p->scale_delay_ns + p->force_delay_ns) * p->step_hz <= INT64_C(16000000000),
         cam_servo_refused_force_delay_ns},
        {p->force_limit_mn <= p->continuous_mn * cam_servo_most_overload,
         cam_servo_refused_force_limit_mn},
    };
    for (uint32_t i = 0; i < sizeof bounds / sizeof bounds[0]; i++) {
        if (!bounds[i].is_within) {
            return bounds[i].which;
        }
    }
    return cam_servo_refused_none;
}

/// Fit a coefficient of 0 or more into its word. @return whether it does
static bool fit_word(int32_t *to, double v)
{
    *to = cam_nearest(v);
    return *to <= cam_servo_most_gain;
}

/// K of MATHS.md (234), by the magnitude of the lead at the crossover. @return [N/um]
static double gain(const cam_servo_params_t *p)
{
    const double omega = 2.0 * CAM_PI * p->crossover_hz;
    const double lag = (double)p->crossover_hz / p->pole_hz;
    const double lead = p->lead_percent / 100.0 * lag;
    return omega * omega * p->mass_g * 1e-9 * cam_root((1.0 + lag * lag) / (1.0 + lead * lead));
}

/// PI with lead, MATHS.md (234).
static cam_servo_refused_t make_pi_lead(const cam_servo_params_t *p, cam_servo_config_t *c)
{
    const double k = gain(p);
    const double more = (p->lead_percent - 100) / 100.0;
    const double corner_hz = p->integral_mHz / 1000.0;
    const double by_pole = corner_hz / p->pole_hz;
    const double x = CAM_PI * p->pole_hz / p->step_hz;
    const double half_ki = k * CAM_PI * corner_hz / p->step_hz;
    const double kp = k * (1.0 + by_pole * more) - half_ki;
    const double kd = k * more * (1.0 - by_pole) / (1.0 + x);
    c->pole_q18 = cam_nearest((1.0 - x) / (1.0 + x) * 0x1p18);
    if (!fit_word(&c->ki_q32, half_ki * 0x1p33)) {
        return cam_servo_refused_integral_mHz;
    }
    if (!fit_word(&c->kp_q18, kp * 0x1p18)) {
        return cam_servo_refused_mass_g;
    }
    return fit_word(&c->kd_q18, kd * 0x1p18) ? cam_servo_refused_none
                                             : cam_servo_refused_lead_percent;
}

/// MATHS.md (235), with tan by its continued fraction.
static cam_servo_notch_t notch(const cam_servo_params_t *p)
{
    if (p->notch_hz == 0) {
        return (cam_servo_notch_t){.b0_q30 = 1 << 30};
    }
    const double x = CAM_PI * p->notch_hz / p->step_hz;
    const double x2 = x * x;
    const double t = x * (105.0 - 10.0 * x2) / (105.0 - 45.0 * x2 + x2 * x2);
    const double base = 1.0 + t * t;
    const double pole = p->notch_pole_permille * t / 500.0;
    const double zero = p->notch_zero_permille * t / 500.0;
    const int32_t b0_q30 = cam_nearest((base + zero) / (base + pole) * 0x1p30);
    const int32_t minus_a2_q30 = cam_nearest((pole - base) / (base + pole) * 0x1p30);
    return (cam_servo_notch_t){.b0_q30 = b0_q30,
                               .b1_q30 = cam_nearest(2.0 * (t * t - 1.0) / (base + pole) * 0x1p30),
                               .b2_q30 = (1 << 30) - b0_q30 - minus_a2_q30,
                               .minus_a2_q30 = minus_a2_q30};
}

/// MATHS.md (236).
static cam_servo_refused_t make_feed_forward(const cam_servo_params_t *p, cam_servo_config_t *c)
{
    const double hz = p->step_hz;
    c->friction_q12 = p->friction_mn * 4096;
    if (!fit_word(&c->mass_q14, p->mass_g * 1e-9 * hz * hz * 0x1p14)) {
        return cam_servo_refused_mass_g;
    }
    if (!fit_word(&c->drag_q14, p->drag_mn_s_per_m * 1e-9 * hz * 0x1p14)) {
        return cam_servo_refused_drag_mn_s_per_m;
    }
    return fit_word(&c->stiffness_q18, p->stiffness_n_per_m * 1e-6 * 0x1p18)
               ? cam_servo_refused_none
               : cam_servo_refused_stiffness_n_per_m;
}

/// Limits, MATHS.md (237), and the instant of the set-point, (233).
static void make_limits(const cam_servo_params_t *p, cam_servo_config_t *c)
{
    const int64_t rate_q6 = (int64_t)p->force_rate_n_per_ms * 64000000 / p->step_hz;
    const int64_t ahead_ns = (int64_t)p->scale_delay_ns + p->force_delay_ns;
    c->limit_q6 = p->force_limit_mn * 64;
    c->continuous_q6 =
        (p->continuous_mn < p->force_limit_mn ? p->continuous_mn : p->force_limit_mn) * 64;
    c->per_continuous = (int32_t)((INT64_C(1) << 43) / c->continuous_q6);
    c->rate_q6 = (int32_t)(rate_q6 < INT64_C(1) << 29 ? rate_q6 : INT64_C(1) << 29);
    c->cooling_q32 = (int32_t)(INT64_C(4294967296000) / ((int64_t)p->thermal_ms * p->step_hz));
    const int64_t steps_q16 = -((ahead_ns * p->step_hz * 4096 + 31250000) / 62500000);
    c->ahead = (cam_servo_ahead_t){.steps_q16 = (int32_t)steps_q16,
                                   .half_square_q16 = (int32_t)(steps_q16 * steps_q16 / 131072),
                                   .third_q28 = (int32_t)(steps_q16 * 4096 / 3)};
}

cam_servo_refused_t cam_servo_design(const cam_servo_params_t *p, cam_servo_config_t *cfg)
{
    *cfg = (cam_servo_config_t){.notch = {.b0_q30 = 1 << 30}};
    cam_servo_refused_t refused = check_bounds(p);
    if (refused != cam_servo_refused_none) {
        return refused;
    }
    cfg->notch = notch(p);
    make_limits(p, cfg);
    refused = make_pi_lead(p, cfg);
    return refused == cam_servo_refused_none ? make_feed_forward(p, cfg) : refused;
}
