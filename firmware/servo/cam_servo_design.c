// SPDX-License-Identifier: Apache-2.0
#include "cam_servo_design.h"
#include "cam_fix.h"  // cam_is_between
#include "cam_real.h" // cam_real_t
#include <stdbool.h>  // bool

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

static cam_real_t real(int32_t v)
{
    return cam_real((uint32_t)v);
}

static cam_real_t ratio(int32_t a, int32_t b)
{
    return cam_real_over(real(a), real(b));
}

static cam_real_t square(cam_real_t a)
{
    return cam_real_times(a, a);
}

/// @return v 10^-9
static cam_real_t nano(cam_real_t v)
{
    return cam_real_over(v, cam_real(1000000000));
}

/// Fit a coefficient into its word. @return whether it does
static bool fit_word(int32_t *to, int64_t v)
{
    *to = (int32_t)v;
    return cam_is_between(v, 0, cam_servo_most_gain);
}

/// K of MATHS.md (234), by the magnitude of the lead at the crossover. @return [N/um]
static cam_real_t gain(const cam_servo_params_t *p, cam_real_t lead)
{
    const cam_real_t cross2 = square(real(p->crossover_hz));
    const cam_real_t pole2 = square(real(p->pole_hz));
    const cam_real_t above = cam_real_plus(pole2, cross2);
    const cam_real_t below = cam_real_plus(pole2, cam_real_times(square(lead), cross2));
    const cam_real_t omega2 =
        cam_real_times(square(cam_real_plus(CAM_REAL_PI, CAM_REAL_PI)), cross2);
    const cam_real_t stiffness = nano(cam_real_times(omega2, real(p->mass_g)));
    return cam_real_times(stiffness, cam_real_root(cam_real_over(above, below)));
}

/// PI with lead, MATHS.md (234).
static cam_servo_refused_t make_pi_lead(const cam_servo_params_t *p, cam_servo_config_t *c)
{
    const cam_real_t one = cam_real(1);
    const cam_real_t lead = ratio(p->lead_percent, 100);
    const cam_real_t more = ratio(p->lead_percent - 100, 100);
    const cam_real_t k = gain(p, lead);
    const cam_real_t corner = nano(cam_real_times(real(p->integral_mHz), cam_real(1000000)));
    const cam_real_t by_pole = cam_real_over(corner, real(p->pole_hz));
    const cam_real_t x = cam_real_times(CAM_REAL_PI, ratio(p->pole_hz, p->step_hz));
    const cam_real_t half_ki =
        cam_real_times(cam_real_times(k, CAM_REAL_PI), cam_real_over(corner, real(p->step_hz)));
    const cam_real_t kp = cam_real_times(k, cam_real_plus(one, cam_real_times(by_pole, more)));
    const cam_real_t kd =
        cam_real_over(cam_real_times(cam_real_times(k, more), cam_real_minus(one, by_pole)),
                      cam_real_plus(one, x));
    const cam_real_t two = cam_real(2);
    c->pole_q18 = (int32_t)cam_real_to_q(cam_real_over(two, cam_real_plus(one, x)), 18) - (1 << 18);
    if (!fit_word(&c->ki_q32, cam_real_to_q(half_ki, 33))) {
        return cam_servo_refused_integral_mHz;
    }
    if (!fit_word(&c->kp_q18, cam_real_to_q(cam_real_minus(kp, half_ki), 18))) {
        return cam_servo_refused_mass_g;
    }
    return fit_word(&c->kd_q18, cam_real_to_q(kd, 18)) ? cam_servo_refused_none
                                                       : cam_servo_refused_lead_percent;
}

/// @return tan(x) by its continued fraction, 0 <= x <= pi / 4, within 2e-6
static cam_real_t tangent(cam_real_t x)
{
    const cam_real_t x2 = square(x);
    const cam_real_t all = cam_real(105);
    const cam_real_t above = cam_real_minus(all, cam_real_times(cam_real(10), x2));
    const cam_real_t most = cam_real_plus(all, square(x2));
    const cam_real_t below = cam_real_minus(most, cam_real_times(cam_real(45), x2));
    return cam_real_times(x, cam_real_over(above, below));
}

/// MATHS.md (235).
static cam_servo_notch_t notch(const cam_servo_params_t *p)
{
    if (p->notch_hz == 0) {
        return (cam_servo_notch_t){.b0_q30 = 1 << 30};
    }
    const cam_real_t t = tangent(cam_real_times(CAM_REAL_PI, ratio(p->notch_hz, p->step_hz)));
    const cam_real_t base = cam_real_plus(cam_real(1), square(t));
    const cam_real_t zero = cam_real_times(ratio(2 * p->notch_zero_permille, 1000), t);
    const cam_real_t pole = cam_real_times(ratio(2 * p->notch_pole_permille, 1000), t);
    const cam_real_t below = cam_real_plus(base, pole);
    const int64_t b0 = cam_real_to_q(cam_real_over(cam_real_plus(base, zero), below), 30);
    const int64_t sum = cam_real_to_q(cam_real_over(base, below), 31); // 1 + a2
    const int64_t rest = cam_real_to_q(cam_real_over(cam_real(4), below), 30);
    return (cam_servo_notch_t){.b0_q30 = (int32_t)b0,
                               .b1_q30 = (int32_t)(sum - rest),
                               .b2_q30 = (int32_t)(sum - b0),
                               .minus_a2_q30 = (int32_t)((INT64_C(1) << 30) - sum)};
}

/// MATHS.md (236).
static cam_servo_refused_t make_feed_forward(const cam_servo_params_t *p, cam_servo_config_t *c)
{
    const cam_real_t hz = real(p->step_hz);
    const cam_real_t mass = nano(cam_real_times(real(p->mass_g), square(hz)));
    const cam_real_t drag = nano(cam_real_times(real(p->drag_mn_s_per_m), hz));
    c->friction_q12 = p->friction_mn * 4096;
    if (!fit_word(&c->mass_q14, cam_real_to_q(mass, 14))) {
        return cam_servo_refused_mass_g;
    }
    if (!fit_word(&c->drag_q14, cam_real_to_q(drag, 14))) {
        return cam_servo_refused_drag_mn_s_per_m;
    }
    const cam_real_t stiffness = ratio(p->stiffness_n_per_m, 1000000);
    return fit_word(&c->stiffness_q18, cam_real_to_q(stiffness, 18))
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
