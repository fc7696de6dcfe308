// SPDX-License-Identifier: Apache-2.0
// A drive that takes positions against closed forms, and one of kind force against the motion of a
// mass after a first-order amplifier.
#include "sim_drive.h"
#include "sim_config.h"
#include "sim_units.h" // SIM_TWO_PI
#include "unity.h"
#include <math.h> // exp, sin

#define PERIOD_S 50e-6
#define STEP_NM 1000.0

static sim_drive_config_t config;
static sim_drive_t drive;

void setUp(void)
{
    config = sim_config_defaults().lathe.drive[hal_axis_u];
    config.delay_us = 0.0;
    config.quantum_micro = 0.0;
}

/// Closed form of the step response, an independent expression for each damping.
static double step_response(double t_s)
{
    const double w = SIM_TWO_PI * config.bandwidth_hz;
    const double d = config.damping;
    if (t_s <= 0.0) {
        return 0.0;
    }
    if (d == 1.0) {
        return 1.0 - exp(-w * t_s) * (1.0 + w * t_s);
    }
    if (d < 1.0) {
        const double q = sqrt(1.0 - d * d);
        return 1.0 - exp(-d * w * t_s) / q * sin(w * q * t_s + acos(d));
    }
    const double q = sqrt(d * d - 1.0);
    const double slow = w * (d - q);
    const double fast = w * (d + q);
    return 1.0 - (fast * exp(-slow * t_s) - slow * exp(-fast * t_s)) / (fast - slow);
}

static void begin(double period_s)
{
    sim_drive_init(&drive, &config, 0.0, period_s);
}

static void expect_response(double t_s)
{
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, STEP_NM * step_response(t_s), drive.pos_micro);
}

static void test_step_response_is_exact_for_every_damping_and_dead_time(void)
{
    static const double cases[][2] = {{0.1, 0.0},   {0.7, 0.0},   {1.0, 0.0},  {2.5, 0.0},
                                      {0.7, 10.0},  {0.7, 50.0},  {0.7, 75.0}, {0.7, 149.99999},
                                      {0.7, 150.0}, {0.7, 1234.5}};
    for (int k = 0; k < 10; k++) {
        config.damping = cases[k][0];
        config.delay_us = cases[k][1];
        begin(PERIOD_S);
        for (int i = 1; i <= 400; i++) {
            sim_drive_step(&drive, (int32_t)STEP_NM, true);
            expect_response(i * PERIOD_S - config.delay_us * 1e-6);
        }
    }
}

static void test_dead_time_of_whole_ticks_is_found_in_spite_of_rounding(void)
{
    config.delay_us = 75.0;
    begin(1.0 / 40000.0);
    TEST_ASSERT_EQUAL_UINT32(3u, drive.n_delay);
    TEST_ASSERT_FALSE(drive.is_split);
}

static void test_limits_are_kept_and_the_way_is_right(void)
{
    config.speed_units_per_s = 100.0;
    config.acceleration_units_per_s2 = 20000.0;
    begin(PERIOD_S);
    sim_drive_t fine;
    sim_drive_init(&fine, &config, 0.0, PERIOD_S / 50);
    double before = 0.0;
    for (int i = 0; i < 1000; i++) {
        sim_drive_step(&drive, 2000000, true);
        for (int k = 0; k < 50; k++) {
            sim_drive_step(&fine, 2000000, true);
        }
        TEST_ASSERT_TRUE(fabs(drive.vel_micro_per_s) <= 100e6);
        TEST_ASSERT_TRUE(fabs(drive.vel_micro_per_s - before) <= 20e9 * PERIOD_S * (1.0 + 1e-9));
        TEST_ASSERT_DOUBLE_WITHIN(100.0, fine.pos_micro, drive.pos_micro); // of 2 mm
        before = drive.vel_micro_per_s;
    }
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 2000000.0, drive.pos_micro);
}

static void test_disabled_drive_brakes_to_rest_and_holds(void)
{
    begin(PERIOD_S);
    drive.vel_micro_per_s = 40e6;
    for (int i = 0; i < 100; i++) {
        sim_drive_step(&drive, 12345, false);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, drive.vel_micro_per_s);
    TEST_ASSERT_DOUBLE_WITHIN(160.0, 3200.0, drive.pos_micro); // v^2 / 2a, ends inside a tick
}

static void test_quantum_rounds_command_and_measurement(void)
{
    config.quantum_micro = 10.0;
    begin(PERIOD_S);
    for (int i = 0; i < 2000; i++) {
        sim_drive_step(&drive, 1234, true);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1230.0, drive.pos_micro);
    drive.command_quantum_micro = 100.0; // of the command alone
    for (int i = 0; i < 2000; i++) {
        sim_drive_step(&drive, 1234, true);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1200.0, drive.pos_micro);
    drive.pos_micro = 1226.0;
    TEST_ASSERT_EQUAL_INT32(1230, sim_drive_measured_micro(&drive));
    drive.pos_micro = -1e12;
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, sim_drive_measured_micro(&drive));
}

/// Lingering, and two steps of other lengths than a period: each command is in force from the dead
/// time on.
static void test_step_in_another_time_is_exact(void)
{
    begin(PERIOD_S);
    sim_drive_step(&drive, (int32_t)STEP_NM, true);
    sim_drive_linger(&drive, 33e-6, true);
    expect_response(PERIOD_S + 33e-6);
    config.delay_us = 0.3 * PERIOD_S * 1e6;
    begin(PERIOD_S);
    sim_drive_step_in(&drive, (int32_t)STEP_NM, true, 0.8 * PERIOD_S);
    expect_response(0.5 * PERIOD_S);
    sim_drive_step_in(&drive, (int32_t)STEP_NM, true, 1.4 * PERIOD_S);
    expect_response(1.9 * PERIOD_S);
    sim_drive_step_in(&drive, 0, false, 0.5 * PERIOD_S); // brakes
    TEST_ASSERT_TRUE(drive.vel_micro_per_s >= 0.0);
    const double at_micro = drive.pos_micro;
    drive.is_blocked = true;
    sim_drive_step_in(&drive, 0, true, PERIOD_S);
    TEST_ASSERT_TRUE(drive.pos_micro == at_micro);
}

// Kind force

static void begin_force(void)
{
    config = sim_config_defaults().lathe.drive[hal_axis_u];
    config.kind = sim_drive_force;
    config.quantum_micro = 0.0;
    config.speed_units_per_s = 1e5;
}

/// @return [nm] travel of the mass a time after a step of the force
static double travel_nm(double force_n, double time_s)
{
    const double tau_s = 1.0 / (SIM_TWO_PI * config.amplifier_hz);
    const double t_s = time_s - config.delay_us * 1e-6;
    const double lag_s2 = tau_s * t_s - tau_s * tau_s * (1.0 - exp(-t_s / tau_s));
    return t_s > 0.0 ? 1e9 * force_n / config.mass_kg * (0.5 * t_s * t_s - lag_s2) : 0.0;
}

static void check_push(double commanded_n, double acting_n)
{
    begin(PERIOD_S);
    sim_drive_push(&drive, commanded_n);
    for (int i = 1; i <= 100; i++) {
        sim_drive_step(&drive, 12345, true); // the position is ignored
        const double wanted_nm = travel_nm(acting_n, i * PERIOD_S);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6 * fabs(wanted_nm) + 1e-3, wanted_nm, drive.pos_micro);
    }
}

static void test_force_moves_the_mass_and_is_limited(void)
{
    begin_force();
    check_push(5000.0, config.force_limit_n);
    check_push(-5000.0, -config.force_limit_n);
    static const double delays_us[] = {0.0, 50.0, 75.0};
    for (int i = 0; i < 3; i++) {
        config.delay_us = delays_us[i];
        check_push(30.0, 30.0);
        check_push(-30.0, -30.0);
    }
}

static void test_disabled_drive_ignores_the_force_and_brakes(void)
{
    begin_force();
    check_push(30.0, 30.0);
    const double moving_micro_per_s = drive.vel_micro_per_s;
    const double braking_micro_per_s = config.acceleration_units_per_s2 * SIM_MICRO * PERIOD_S;
    sim_drive_step(&drive, 0, false);
    TEST_ASSERT_DOUBLE_WITHIN(1.0, moving_micro_per_s - braking_micro_per_s, drive.vel_micro_per_s);
    for (int i = 0; i < 100; i++) {
        sim_drive_step(&drive, 0, false);
    }
    TEST_ASSERT_TRUE(drive.vel_micro_per_s == 0.0);
}
