// SPDX-License-Identifier: Apache-2.0
// A drive of kind force against the motion of a mass behind a first-order amplifier.
#include "sim_drive.h"
#include "sim_units.h"
#include "unity.h"
#include <math.h> // exp

#define STEP_S 50e-6

static sim_drive_config_t config;
static sim_drive_t drive;

void setUp(void)
{
    config = sim_drive_u_defaults();
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

static void check_step(double commanded_n, double acting_n)
{
    sim_drive_init(&drive, &config, 0.0, STEP_S);
    sim_drive_push(&drive, commanded_n);
    for (int i = 1; i <= 100; i++) {
        sim_drive_step(&drive, 12345, true); // the position is ignored
        const double wanted_nm = travel_nm(acting_n, i * STEP_S);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6 * fabs(wanted_nm) + 1e-3, wanted_nm, drive.pos_micro);
    }
}

static void test_force_moves_the_mass(void)
{
    static const double delays_us[] = {0.0, 50.0, 75.0};
    for (int i = 0; i < 3; i++) {
        config.delay_us = delays_us[i];
        check_step(30.0, 30.0);
        check_step(-30.0, -30.0);
    }
}

static void test_force_is_limited(void)
{
    check_step(5000.0, config.force_limit_n);
}

static void test_disabled_drive_ignores_the_force_and_brakes(void)
{
    check_step(30.0, 30.0);
    const double moving_micro_per_s = drive.vel_micro_per_s;
    const double braking_micro_per_s = config.acceleration_units_per_s2 * SIM_MICRO * STEP_S;
    sim_drive_step(&drive, 0, false);
    TEST_ASSERT_DOUBLE_WITHIN(1.0, moving_micro_per_s - braking_micro_per_s, drive.vel_micro_per_s);
    for (int i = 0; i < 100; i++) {
        sim_drive_step(&drive, 0, false);
    }
    TEST_ASSERT_TRUE(drive.vel_micro_per_s == 0.0);
}

/// 30 N compress a stop of 10 N/um by 3 um; a push back leaves it at once.
static void test_stop_holds_the_mass_and_lets_it_go(void)
{
    config.stop_units = 0.1;
    for (int side = -1; side <= 1; side += 2) {
        sim_drive_init(&drive, &config, 0.0, STEP_S);
        sim_drive_push(&drive, side * 30.0);
        double most_micro = 0.0;
        for (int i = 0; i < 4000; i++) {
            sim_drive_step(&drive, 0, true);
            most_micro = fmax(most_micro, fabs(drive.pos_micro));
        }
        TEST_ASSERT_DOUBLE_WITHIN(1.0, side * 103e3, drive.pos_micro);
        TEST_ASSERT_TRUE(most_micro < 130e3); // 63 mm/s, at 2600 rad/s
        sim_drive_push(&drive, side * -30.0);
        for (int i = 0; i < 100; i++) {
            sim_drive_step(&drive, 0, true);
        }
        const double freed_nm = travel_nm(30.0, 100 * STEP_S);
        TEST_ASSERT_DOUBLE_WITHIN(0.2 * freed_nm, 103e3 - freed_nm, side * drive.pos_micro);
    }
}
