// SPDX-License-Identifier: Apache-2.0
/// servo_bench: a loop of 1.5 kg at 20 kHz for the tests of the servo.
#ifndef SERVO_BENCH_H
#define SERVO_BENCH_H

#include "cam_servo_design.h"
#include "unity.h"

static const cam_servo_params_t bench_params = {
    .step_hz = 20000,
    .mass_g = 1500,
    .crossover_hz = 469,
    .lead_percent = 5900,
    .pole_hz = 4000,
    .integral_mhz = 20500,
    .notch_hz = 1210,
    .notch_zero_permille = 60,
    .notch_pole_permille = 700,
    .scale_delay_ns = 2000,
    .force_delay_ns = 75000,
    .drag_mn_s_per_m = 12000,
    .friction_mn = 5000,
    .stiffness_n_per_m = 900,
    .force_limit_mn = 345000,
    .force_rate_n_per_ms = 1000000,
    .continuous_mn = 214000,
    .thermal_ms = 20000,
};

static inline cam_servo_config_t bench_config(const cam_servo_params_t *p)
{
    cam_servo_config_t c;
    const cam_servo_refused_t refused = cam_servo_design(p, &c);
    TEST_ASSERT_EQUAL_STRING("none", cam_servo_refused_name(refused));
    return c;
}

#endif
