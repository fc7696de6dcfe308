// SPDX-License-Identifier: Apache-2.0
#include "sim_servo.h"
#include "sim_drive.h" // sim_drive_step
#include "sim_units.h" // SIM_TWO_PI
#include "unity.h"
#include <math.h> // cos, lround, sin

#define PERIOD_S 50e-6

static sim_drive_config_t config;
static sim_drive_t drive;

void setUp(void)
{
    config = sim_drive_u_defaults();
    config.kind = sim_drive_force;
    config.bandwidth_hz = 180.0;
    config.quantum_micro = 0.0;
}

/// [nm] largest error behind a sine of 0.3 mm that is led by an inverse
static double worst_behind(const sim_servo_equivalent_t *worth, double hz)
{
    const double f = SIM_TWO_PI * hz;
    double worst = 0.0;
    sim_drive_init(&drive, &config, 0.0, PERIOD_S);
    for (int i = 0; i < 40000; i++) {
        const double t_s = i * PERIOD_S;
        const double off = fabs(drive.pos_micro - 3e5 * sin(f * t_s));
        worst = i > 38000 && off > worst ? off : worst;
        const double ahead = f * (t_s + worth->lead_s);
        const double command =
            3e5 * ((1.0 - f * f * worth->k2_s2) * sin(ahead) + f * worth->k1_s * cos(ahead));
        sim_drive_step(&drive, (int32_t)lround(command), true);
    }
    return worst;
}

/// The fit is good for 0.8 % of the swing over the frequencies of cutting.
static void test_inverse_of_what_it_is_worth_makes_it_follow(void)
{
    config.force_limit_n = 5000.0;
    const sim_servo_equivalent_t worth = sim_servo_equivalent(&config, PERIOD_S);
    static const double hz[] = {25.0, 50.0, 100.0, 150.0};
    for (int i = 0; i < 4; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(0.008 * 3e5, 0.0, worst_behind(&worth, hz[i]));
    }
}

/// A stiff amplifier without dead time at a fine period is the second order that it is tuned for.
static void test_fast_loop_is_worth_what_it_is_tuned_for(void)
{
    config.delay_us = 0.0;
    config.amplifier_hz = 1e6;
    config.bandwidth_hz = 20.0;
    const sim_servo_equivalent_t worth = sim_servo_equivalent(&config, 1e-6);
    const double w = SIM_TWO_PI * 20.0;
    TEST_ASSERT_DOUBLE_WITHIN(0.15 / w, 2.0 * 0.7 / w, worth.k1_s + worth.lead_s);
}

static void test_wrong_mass_makes_another_loop(void)
{
    const sim_servo_equivalent_t right = sim_servo_equivalent(&config, PERIOD_S);
    config.tuned_mass_kg = 1.2 * config.mass_kg;
    sim_servo_t servo;
    sim_servo_init(&servo, &config, PERIOD_S);
    const double w = SIM_TWO_PI * 180.0;
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 1.2 * w * w, servo.kp_per_s2);
    TEST_ASSERT_TRUE(worst_behind(&right, 100.0) > 3000.0);
}

/// The sum of the loop takes a constant force away; the drive rests where it is told to.
static void test_constant_force_is_taken_away(void)
{
    config.friction_m_per_s2 = 0.0;
    sim_drive_init(&drive, &config, 0.0, PERIOD_S);
    for (int i = 0; i < 60000; i++) {
        sim_drive_disturb(&drive, -30.0);
        sim_drive_step(&drive, 100000, true);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 100000.0, drive.pos_micro);
}

static void test_force_is_limited(void)
{
    config.force_limit_n = 15.0; // 10 m/s2
    sim_drive_init(&drive, &config, 0.0, PERIOD_S);
    double before = 0.0;
    for (int i = 0; i < 2000; i++) {
        sim_drive_step(&drive, 1000000, true);
        const double gained = fabs(drive.vel_micro_per_s - before);
        TEST_ASSERT_TRUE(gained <= 10e9 * PERIOD_S * (1.0 + 1e-9));
        before = drive.vel_micro_per_s;
    }
}

static void test_loop_begins_anew_when_it_is_enabled_again(void)
{
    sim_drive_init(&drive, &config, 0.0, PERIOD_S);
    for (int i = 0; i < 4000; i++) {
        sim_drive_step(&drive, 50000, true);
    }
    for (int i = 0; i < 100; i++) {
        sim_drive_step(&drive, 0, false);
    }
    TEST_ASSERT_TRUE(drive.vel_micro_per_s == 0.0);
    const double rest = drive.pos_micro;
    sim_drive_step(&drive, (int32_t)lround(rest), true);
    sim_drive_step(&drive, (int32_t)lround(rest), true);
    TEST_ASSERT_DOUBLE_WITHIN(1.0, rest, drive.pos_micro);
}
