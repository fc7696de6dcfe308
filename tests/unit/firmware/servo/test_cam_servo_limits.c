// SPDX-License-Identifier: Apache-2.0
// Force, its rate, heat, windup, and inputs beyond everything.
#include "cam_servo.h"
#include "fixture_random.h"
#include "fixture_servo.h"
#include <math.h>   // exp, sqrt
#include <stdlib.h> // labs

static cam_params_t p;
static cam_servo_t servo;

void setUp(void)
{
    p = bench_params;
    servo = (cam_servo_t){0};
}

static void test_force_and_its_rate_are_limited(void)
{
    p.servo_force_rate_n_per_ms = 100; // 5 N per step
    const cam_servo_config_t c = bench_config(&p);
    cam_servo_input_t in = {.set_q6 = 0};
    cam_servo_start_isr(&servo, &c, &in);
    int32_t last = 0;
    for (int i = 0; i < 400; i++) {
        in.actual_q6 = i < 200 ? -100000000 : 100000000;
        const int32_t force = cam_servo_step_isr(&servo, &c, &in);
        TEST_ASSERT_INT32_WITHIN(345000 * 64, 0, force);
        TEST_ASSERT_INT32_WITHIN(5000 * 64, last, force);
        TEST_ASSERT_TRUE(servo.is_limited);
        last = force;
        if (i % 200 == 199) {
            TEST_ASSERT_EQUAL_INT32(i < 200 ? 345000 * 64 : -345000 * 64, force);
        }
    }
}

/// Start clears all state of a limited loop except its heat; the first force has no kick.
static void test_start_clears_all_but_the_heat(void)
{
    const cam_servo_config_t c = bench_config(&p);
    cam_servo_input_t in = {.actual_q6 = -100000000};
    cam_servo_t fresh = {0};
    for (int i = 0; i < 200; i++) {
        in.actual_q6 += 1000; // so that the lead is not 0
        (void)cam_servo_step_isr(&servo, &c, &in);
    }
    TEST_ASSERT_TRUE(servo.is_limited && servo.heat_q54 > 0);
    fresh.heat_q54 = servo.heat_q54;
    in.actual_q6 = -1000;
    cam_servo_start_isr(&servo, &c, &in);
    cam_servo_start_isr(&fresh, &c, &in);
    TEST_ASSERT_EQUAL_MEMORY(&fresh, &servo, sizeof fresh);
    const double back = (double)c.kp_q18 * 1000.0 / 262144.0;
    TEST_ASSERT_INT32_WITHIN(2 + (int32_t)back / 50,
                             (int32_t)(back * c.notch.b0_q30 / 1073741824.0),
                             cam_servo_step_isr(&servo, &c, &in));
}

/// To the last digit on top of all else, and within the same limit.
static void test_push_is_added_before_the_limit(void)
{
    const cam_servo_config_t c = bench_config(&p);
    cam_servo_t without = {0};
    fixture_random_t dice = {3};
    cam_servo_input_t in = {.set_q6 = 640};
    cam_servo_start_isr(&servo, &c, &in);
    cam_servo_start_isr(&without, &c, &in);
    for (int i = 0; i < 1000; i++) {
        in.actual_q6 = (int32_t)fixture_random_range(&dice, 0, 1000);
        in.push_q6 = 0;
        const int32_t rest_q6 = cam_servo_step_isr(&without, &c, &in);
        in.push_q6 = (int32_t)fixture_random_range(&dice, -200000 * 64, 200000 * 64);
        TEST_ASSERT_EQUAL_INT32(rest_q6 + in.push_q6, cam_servo_step_isr(&servo, &c, &in));
    }
    in.push_q6 = 600000 * 64;
    TEST_ASSERT_EQUAL_INT32(345000 * 64, cam_servo_step_isr(&servo, &c, &in));
    TEST_ASSERT_TRUE(servo.is_limited);
    servo.is_hot = true;
    TEST_ASSERT_EQUAL_INT32(214000 * 64, cam_servo_step_isr(&servo, &c, &in));
}

/// Held at the limit of the force, then of its rate, for a second, the integral is what the first
/// few steps made it.
static void test_integral_does_not_wind_up_at_a_limit(void)
{
    for (int is_rate = 0; is_rate < 2; is_rate++) {
        setUp();
        p.servo_force_limit_mn = is_rate != 0 ? 4000000 : p.servo_force_limit_mn;
        p.servo_continuous_mn = p.servo_force_limit_mn;
        p.servo_force_rate_n_per_ms = is_rate != 0 ? 1 : p.servo_force_rate_n_per_ms;
        const cam_servo_config_t c = bench_config(&p);
        cam_servo_input_t in = {.set_q6 = 0};
        cam_servo_start_isr(&servo, &c, &in);
        in.actual_q6 = -25000000; // 0.4 mm, beyond any limit
        for (int i = 0; i < 20000; i++) {
            (void)cam_servo_step_isr(&servo, &c, &in);
        }
        TEST_ASSERT_TRUE(servo.is_limited);
        TEST_ASSERT_LESS_OR_EQUAL_INT64(10 * (int64_t)c.ki_q32 * 25000000, servo.sum_q38);
    }
}

/// A step of 0.1 mm through a double integrator at 30 N: the overshoot is that of the linear loop.
static void test_limited_step_overshoots_no_more_than_a_small_one(void)
{
    p.servo_force_limit_mn = 30000;
    p.servo_continuous_mn = 30000;
    p.servo_notch_hz = 0;
    const cam_servo_config_t c = bench_config(&p);
    double relative[2];
    static const double steps_nm[] = {50.0, 10000.0};
    for (int k = 0; k < 2; k++) {
        double pos = 0.0;
        double vel = 0.0;
        double most = 0.0;
        cam_servo_input_t in = {.set_q6 = 0};
        cam_servo_start_isr(&servo, &c, &in);
        in.set_q6 = (int32_t)(64.0 * steps_nm[k]);
        for (int i = 0; i < 4000; i++) {
            in.actual_q6 = (int32_t)(64.0 * pos);
            const double a = cam_servo_step_isr(&servo, &c, &in) / 64e3 / 1.5 * 1e9 / 4e8;
            pos += vel + 0.5 * a;
            vel += a;
            most = pos > most ? pos : most;
        }
        relative[k] = most / steps_nm[k] - 1.0;
        TEST_ASSERT_DOUBLE_WITHIN(1.0 + 0.001 * steps_nm[k], steps_nm[k], pos);
    }
    TEST_ASSERT_TRUE(relative[1] <= relative[0] + 0.02);
}

/// At twice the continuous force the model is at 1 after -tau ln(3/4).
static void test_heat_limits_to_the_continuous_force(void)
{
    p.servo_force_limit_mn = 200000;
    p.servo_continuous_mn = 100000;
    p.servo_thermal_ms = 1000;
    const cam_servo_config_t c = bench_config(&p);
    const cam_servo_input_t in = {.actual_q6 = -100000000};
    cam_servo_start_isr(&servo, &c, &in);
    int first_hot = 0;
    double heat = 0.0; // in double precision
    for (int i = 0; i < 60000; i++) {
        const int32_t force = cam_servo_step_isr(&servo, &c, &in);
        if (servo.is_hot && first_hot == 0) {
            first_hot = i;
        }
        const double share = force / 6.4e6;
        heat += (share * share - heat) / 20000.0;
        if (i > 10 && (first_hot == 0 || i > first_hot + 10)) {
            TEST_ASSERT_EQUAL_INT32(first_hot == 0 ? 12800000 : 6400000, force);
        }
    }
    TEST_ASSERT_INT_WITHIN(10, (int)(20000.0 * log(4.0 / 3.0)), first_hot);
    TEST_ASSERT_DOUBLE_WITHIN(2e-3, heat, (double)servo.heat_q54 / 18014398509481984.0);
    TEST_ASSERT_TRUE(servo.is_hot);
    int cooled = 0;
    for (; servo.is_hot; cooled++) {
        cam_servo_rest_isr(&servo, &c);
        TEST_ASSERT_FALSE(servo.is_limited);
    }
    TEST_ASSERT_INT_WITHIN(100, (int)(20000.0 * log(8.0 / 7.0)), cooled);
}

static int32_t extreme(fixture_random_t *dice)
{
    static const int32_t most[] = {INT32_MIN, INT32_MAX, 0, 1, -1, INT32_MIN + 1};
    const int64_t which = fixture_random_range(dice, 0, 11);
    return which < 6 ? most[which] : (int32_t)fixture_random_u32(dice);
}

/// The largest coefficients and any inputs; the sanitizer watches the sums.
static void test_extremes_stay_within_the_limits(void)
{
    fixture_random_t dice = {.state = 3};
    const int32_t full = cam_servo_most_gain;
    const cam_servo_config_t base = bench_config(&p);
    for (int round = 0; round < 200 / fixture_rarer; round++) {
        cam_servo_config_t c = base;
        c.kp_q18 = c.kd_q18 = c.ki_q32 = c.mass_q14 = c.drag_q14 = full;
        c.stiffness_q18 = c.friction_q12 = full;
        c.pole_q18 = (int32_t)fixture_random_range(&dice, 0, 1 << 18);
        c.ahead = (cam_servo_ahead_t){-(8 << 16), 32 << 16, -1431655765};
        c.limit_q6 = cam_servo_most_q6;
        c.per_continuous = INT32_MAX;
        c.cooling_q32 = INT32_MAX;
        c.rate_q6 = round % 2 == 0 ? 1 << 29 : 64;
        if (round % 3 == 0) {
            c.notch = (cam_servo_notch_t){1 << 30, INT32_MIN, 1 << 30, -(1 << 30)};
        }
        for (int i = 0; i < 2000; i++) {
            const cam_servo_input_t in = {extreme(&dice), extreme(&dice), extreme(&dice),
                                          extreme(&dice), extreme(&dice)};
            if (i % 500 == 0) {
                cam_servo_start_isr(&servo, &c, &in);
            }
            const int32_t last = servo.force_q6;
            const int32_t force = cam_servo_step_isr(&servo, &c, &in);
            TEST_ASSERT_INT32_WITHIN(cam_servo_most_q6, 0, force);
            TEST_ASSERT_INT32_WITHIN(c.rate_q6, last, force);
        }
    }
}
