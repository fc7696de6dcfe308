// SPDX-License-Identifier: Apache-2.0
// What the design refuses, and how near its coefficients are; the response is in test_cam_servo.c.
#include "cam_feasible_inner.h"
#include "fixture_servo.h"
#include <math.h> // fabs, tan
#include <stddef.h>

static cam_servo_params_t p;
static cam_servo_config_t c;

void setUp(void)
{
    p = bench_params;
}

static void expect_refused(cam_servo_refused_t which)
{
    TEST_ASSERT_EQUAL_INT(which, cam_servo_design(&p, &c));
    p = bench_params;
}

static void set_field(size_t at, int32_t value)
{
    *(int32_t *)(void *)((char *)&p + at) = value;
}

/// On every core to the bit.
static void test_bench_has_these_coefficients(void)
{
    static const cam_servo_config_t right = {
        .kp_q18 = 636488,
        .kd_q18 = 17430224,
        .pole_q18 = 59837,
        .ki_q32 = 51900256,
        .notch = {871334026, -1583026082, 833382564, -630974766},
        .mass_q14 = 9830400,
        .drag_q14 = 3932,
        .stiffness_q18 = 236,
        .friction_q12 = 20480000,
        .limit_q6 = 22080000,
        .rate_q6 = 536870912,
        .continuous_q6 = 13696000,
        .per_continuous = 642238,
        .cooling_q32 = 10737,
        .ahead = {-100925, 77711, -137796266},
    };
    c = bench_config(&p);
    TEST_ASSERT_EQUAL_INT32_ARRAY((const int32_t *)&right, (const int32_t *)&c,
                                  sizeof c / sizeof(int32_t));
}

static void test_bounds_by_other_parameters(void)
{
    static const struct {
        size_t at;
        int32_t value;
        cam_servo_refused_t refused;
    } bounds[] = {
#define BOUND(name, value) {offsetof(cam_servo_params_t, name), value, cam_servo_refused_##name}
        BOUND(pole_hz, 4001),          BOUND(crossover_hz, 4001),
        BOUND(integral_mHz, 470000),   BOUND(notch_hz, 5001),
        BOUND(notch_hz, 19),           BOUND(notch_zero_permille, 701),
        BOUND(force_delay_ns, 799000), BOUND(force_limit_mn, 3210001),
#undef BOUND
    };
    for (size_t i = 0; i < sizeof bounds / sizeof bounds[0]; i++) {
        set_field(bounds[i].at, bounds[i].value);
        expect_refused(bounds[i].refused);
    }
}

/// Not even by less than 1 Hz: beyond the pole, D would be negative.
static void test_integral_is_at_most_the_crossover(void)
{
    for (int32_t more_mHz = 0; more_mHz <= 1; more_mHz++) {
        p.crossover_hz = p.pole_hz = 20;
        p.integral_mHz = 20000 + more_mHz;
        expect_refused(more_mHz == 0 ? cam_servo_refused_none : cam_servo_refused_integral_mHz);
    }
}

static void test_coefficients_that_do_not_fit_are_refused(void)
{
    p.mass_g = 100000;
    p.crossover_hz = 3000;
    p.lead_percent = 100;
    p.integral_mHz = 0;
    expect_refused(cam_servo_refused_mass_g);
    p.mass_g = 50000;
    p.lead_percent = 5000;
    p.crossover_hz = 2000;
    p.integral_mHz = 0;
    expect_refused(cam_servo_refused_lead_percent);
    p.mass_g = 60000;
    p.integral_mHz = 469000;
    expect_refused(cam_servo_refused_integral_mHz);
    p.step_hz = 200000; // 100 kg at 200 kHz are 4 N per nm/step^2
    p.mass_g = 100000;
    p.crossover_hz = 10;
    p.integral_mHz = 0;
    p.force_delay_ns = 30000;
    p.notch_hz = 0;
    expect_refused(cam_servo_refused_mass_g);
    p.step_hz = 1000;
    p.pole_hz = 200;
    p.crossover_hz = 20;
    p.integral_mHz = 20000;
    p.notch_hz = 0;
    p.drag_mn_s_per_m = 10000000;
    expect_refused(cam_servo_refused_none);
}

static void test_without_a_notch_the_signal_passes(void)
{
    static const cam_servo_notch_t passes = {.b0_q30 = 1 << 30};
    c = bench_config(&p);
    p.notch_hz = 0;
    TEST_ASSERT_EQUAL_INT(cam_servo_refused_none, cam_servo_design(&p, &c));
    TEST_ASSERT_EQUAL_MEMORY(&passes, &c.notch, sizeof passes);
    p.pole_hz = 4001;
    TEST_ASSERT_EQUAL_INT(cam_servo_refused_pole_hz, cam_servo_design(&p, &c));
    TEST_ASSERT_EQUAL_MEMORY(&passes, &c.notch, sizeof passes); // also of a refused design
}

/// -(delay times step rate), rounded to steps / 2^16, up to the largest delay.
static void test_instant_of_the_set_point_is_exact(void)
{
    static const struct {
        int32_t delay_ns, steps_q16;
    } cases[] = {{0, 0},          {762, -999},       {763, -1000},       {1000, -1311},
                 {50000, -65536}, {400000, -524288}, {799999, -1048575}, {800000, -1048576}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        p.scale_delay_ns = 0;
        p.force_delay_ns = cases[i].delay_ns;
        TEST_ASSERT_EQUAL_INT(cam_servo_refused_none, cam_servo_design(&p, &c));
        TEST_ASSERT_EQUAL_INT32(cases[i].steps_q16, c.ahead.steps_q16);
    }
}

/// The whole gain at 0 Hz is 1, for every notch.
static void test_notch_has_gain_one_and_its_frequency(void)
{
    for (p.notch_hz = 20; p.notch_hz <= 5000; p.notch_hz += 83) {
        TEST_ASSERT_EQUAL_INT(cam_servo_refused_none, cam_servo_design(&p, &c));
        const cam_servo_notch_t *n = &c.notch;
        TEST_ASSERT_EQUAL_INT64((INT64_C(1) << 30) + n->b1_q30 - n->minus_a2_q30,
                                (int64_t)n->b0_q30 + n->b1_q30 + n->b2_q30);
        const double t = tan(3.14159265358979324 * p.notch_hz / 20000.0);
        const double below = 1.0 + 1.4 * t + t * t;
        TEST_ASSERT_DOUBLE_WITHIN(4e-6, 2.0 * (t * t - 1.0) / below, n->b1_q30 / 1073741824.0);
        TEST_ASSERT_DOUBLE_WITHIN(4e-6, (1.0 + 0.12 * t + t * t) / below, n->b0_q30 / 1073741824.0);
    }
}
