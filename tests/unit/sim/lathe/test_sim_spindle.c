// SPDX-License-Identifier: Apache-2.0
#include "sim_encoder.h"
#include "sim_config.h"
#include "sim_units.h" // SIM_TWO_PI
#include "unity.h"
#include <math.h> // sqrt

#define PERIOD_S 50e-6

static sim_spindle_t spindle;

void setUp(void)
{
    const sim_spindle_config_t config = sim_config_defaults().lathe.spindle;
    sim_spindle_init(&spindle, &config);
}

static void run(double set_rad_per_s, int n, double dt_s)
{
    for (int i = 0; i < n; i++) {
        sim_spindle_step(&spindle, set_rad_per_s, dt_s);
    }
}

static void test_step_is_by_the_torque_and_near_the_set_speed_an_exponential(void)
{
    run(250.0, 2000, PERIOD_S);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 50.0, spindle.speed_rad_per_s); // 500 rad/s2 for 0.1 s
    spindle.speed_rad_per_s = 99.0;
    run(100.0, 500, PERIOD_S);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 100.0 - exp(-40.0 * 0.025), spindle.speed_rad_per_s);
}

static void test_step_run_up_angle_does_not_depend_on_the_period(void)
{
    spindle.ripple = 0.0;
    run(261.8, 20000, PERIOD_S);
    const double coarse = spindle.turn;
    setUp();
    spindle.ripple = 0.0;
    run(261.8, 200000, PERIOD_S / 10);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, spindle.turn, coarse);
}

/// Integral of dturn / (1 + r sin): a whole turn takes 1 / sqrt(1 - r^2) of the time without
/// ripple.
static void test_step_with_ripple_keeps_the_time_of_a_turn(void)
{
    spindle.ripple = 0.1;
    spindle.turn = 0.0;
    spindle.speed_rad_per_s = SIM_TWO_PI * 40.0;
    run(spindle.speed_rad_per_s, 100000, PERIOD_S); // 5 s
    TEST_ASSERT_DOUBLE_WITHIN(200.0 * 0.1 * 3e-5, 200.0 * sqrt(1.0 - 0.01), spindle.turn);
}

static void test_true_speed_ripples_with_its_amplitudes_and_periods(void)
{
    spindle.speed_rad_per_s = 100.0;
    spindle.turn = 7.125; // a quarter period of two per turn
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 100.2, sim_spindle_true_rad_per_s(&spindle));
    spindle.turn = 7.375;
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 99.8, sim_spindle_true_rad_per_s(&spindle));
    spindle.turn = 7.25;
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 100.0, sim_spindle_true_rad_per_s(&spindle));
    spindle.ripple_2 = 0.01;
    spindle.ripple_per_turn_2 = 3.0; // three quarters of a period
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 99.0, sim_spindle_true_rad_per_s(&spindle));
}
