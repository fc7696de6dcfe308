// SPDX-License-Identifier: Apache-2.0
// What the design refuses, and how near its coefficients are; the response is in test_cam_servo.c.
#include "cam_feasible_inner.h"
#include "fixture_servo.h"
#include <math.h> // fabs, tan
#include <stddef.h>
#include <string.h> // memcpy

static cam_params_t p;
static cam_servo_config_t c;

void setUp(void)
{
    p = bench_params;
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

/// Bounds by other parameters, coefficients that do not fit their words, and an integral beyond the
/// crossover, where D would be negative, be it by less than 1 Hz.
static void test_what_does_not_fit_is_refused(void)
{
#define SET(name, value)                                                                           \
    {                                                                                              \
        offsetof(cam_params_t, name), value                                                        \
    }
#define REFUSED(name) cam_param_##name
    static const struct {
        int32_t step_hz;
        cam_param_id_t refused;
        struct {
            size_t at;
            int32_t value;
        } set[6];
    } rows[] = {
        {20000, REFUSED(servo_pole_hz), {SET(servo_pole_hz, 4001)}},
        {20000, REFUSED(servo_crossover_hz), {SET(servo_crossover_hz, 4001)}},
        {20000, REFUSED(servo_integral_mHz), {SET(servo_integral_mHz, 470000)}},
        {20000, REFUSED(servo_notch_hz), {SET(servo_notch_hz, 5001)}},
        {20000, REFUSED(servo_notch_hz), {SET(servo_notch_hz, 19)}},
        {20000, REFUSED(servo_notch_zero_permille), {SET(servo_notch_zero_permille, 701)}},
        {20000, REFUSED(servo_force_delay_ns), {SET(servo_force_delay_ns, 799000)}},
        {20000, REFUSED(servo_force_limit_mn), {SET(servo_force_limit_mn, 3210001)}},
        {20000,
         cam_n_params,
         {SET(servo_crossover_hz, 20), SET(servo_pole_hz, 20), SET(servo_integral_mHz, 20000)}},
        {20000,
         REFUSED(servo_integral_mHz),
         {SET(servo_crossover_hz, 20), SET(servo_pole_hz, 20), SET(servo_integral_mHz, 20001)}},
        {20000,
         REFUSED(servo_mass_g),
         {SET(servo_mass_g, 100000), SET(servo_crossover_hz, 3000), SET(servo_lead_percent, 100),
          SET(servo_integral_mHz, 0)}},
        {20000,
         REFUSED(servo_lead_percent),
         {SET(servo_mass_g, 50000), SET(servo_crossover_hz, 2000), SET(servo_lead_percent, 5000),
          SET(servo_integral_mHz, 0)}},
        {20000,
         REFUSED(servo_integral_mHz),
         {SET(servo_mass_g, 60000), SET(servo_integral_mHz, 469000)}},
        {200000,
         REFUSED(servo_mass_g), // at 200 kHz they are 4 N per nm/step^2
         {SET(servo_mass_g, 100000), SET(servo_crossover_hz, 10), SET(servo_integral_mHz, 0),
          SET(servo_force_delay_ns, 30000), SET(servo_notch_hz, 0)}},
        {1000,
         cam_n_params,
         {SET(servo_drag_mn_s_per_m, 10000000), SET(servo_crossover_hz, 20),
          SET(servo_integral_mHz, 20000), SET(servo_pole_hz, 200), SET(servo_notch_hz, 0)}},
    };
#undef SET
#undef REFUSED
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        p = bench_params;
        for (size_t k = 0; k < 6u && (rows[i].set[k].at != 0u || rows[i].set[k].value != 0); k++) {
            memcpy((char *)&p + rows[i].set[k].at, &rows[i].set[k].value, sizeof(int32_t));
        }
        TEST_ASSERT_EQUAL_INT(rows[i].refused, cam_servo_design(&p, rows[i].step_hz, &c));
    }
}

static void test_without_a_notch_the_signal_passes(void)
{
    static const cam_servo_notch_t passes = {.b0_q30 = 1 << 30};
    c = bench_config(&p);
    p.servo_notch_hz = 0;
    TEST_ASSERT_EQUAL_INT(cam_n_params, cam_servo_design(&p, step_hz, &c));
    TEST_ASSERT_EQUAL_MEMORY(&passes, &c.notch, sizeof passes);
    p.servo_pole_hz = 4001;
    TEST_ASSERT_EQUAL_INT(cam_param_servo_pole_hz, cam_servo_design(&p, step_hz, &c));
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
        p.u_scale_latency_ns = 0;
        p.servo_force_delay_ns = cases[i].delay_ns;
        TEST_ASSERT_EQUAL_INT(cam_n_params, cam_servo_design(&p, step_hz, &c));
        TEST_ASSERT_EQUAL_INT32(cases[i].steps_q16, c.ahead.steps_q16);
    }
}

/// The whole gain at 0 Hz is 1, for every notch.
static void test_notch_has_gain_one_and_its_frequency(void)
{
    for (p.servo_notch_hz = 20; p.servo_notch_hz <= 5000; p.servo_notch_hz += 83) {
        TEST_ASSERT_EQUAL_INT(cam_n_params, cam_servo_design(&p, step_hz, &c));
        const cam_servo_notch_t *n = &c.notch;
        TEST_ASSERT_EQUAL_INT64((INT64_C(1) << 30) + n->b1_q30 - n->minus_a2_q30,
                                (int64_t)n->b0_q30 + n->b1_q30 + n->b2_q30);
        const double t = tan(3.14159265358979324 * p.servo_notch_hz / 20000.0);
        const double below = 1.0 + 1.4 * t + t * t;
        TEST_ASSERT_DOUBLE_WITHIN(4e-6, 2.0 * (t * t - 1.0) / below, n->b1_q30 / 1073741824.0);
        TEST_ASSERT_DOUBLE_WITHIN(4e-6, (1.0 + 0.12 * t + t * t) / below, n->b0_q30 / 1073741824.0);
    }
}
