// SPDX-License-Identifier: Apache-2.0
// Ratio, set-point and acceleration of the modulated spindle against doubles.
#include "cam_build.h"
#include "cam_config.h"
#include "cam_eval.h"
#include "fixture_image.h"
#include "fixture_random.h"
#include "unity.h"
#include <math.h>

#define PI 3.14159265358979323846

static fixture_image_t image;
static cam_table_t table;
static cam_params_t params;
static cam_config_t config;

enum { tick_hz = 20000, clock_hz = 10000000 };

void setUp(void)
{
    const fixture_part_t part = fixture_part_modulated();
    fixture_image_make(&image, &part);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_table_check(image.bytes, image.size, &table));
    params = cam_param_defaults();
    params.spindle_lag_us = 25000;
    TEST_ASSERT_EQUAL_INT(
        cam_ok, cam_build_config(&config, &params, &table, 3000000, tick_hz, clock_hz).err);
}

static void test_ratio_and_slope_are_those_of_the_function(void)
{
    for (int i = 0; i < 4000; i++) {
        const double turn = i / 4000.0;
        const int32_t z_nm = i * 250;
        double r[3];
        fixture_ratio(2.0 * PI * turn, z_nm, r);
        const cam_ratio_t found = cam_speed_ratio_at(&table.speed, (uint32_t)(turn * 4294967296.0),
                                                     cam_eval_height(&table.speed, z_nm));
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, r[0], ldexp(found.ratio_q28, -28));
        TEST_ASSERT_DOUBLE_WITHIN(2e-4, r[1] * 2.0 * PI, ldexp(found.slope_q20, -20));
    }
}

static double random_real(fixture_random_t *random, double low, double high)
{
    return low + (high - low) * ldexp(fixture_random_u32(random), -32);
}

/// Set-point and acceleration of a plan in real numbers.
static void test_set_point_is_the_inverse_of_the_speed_loop(void)
{
    fixture_random_t random = {.state = 7};
    for (int i = 0; i < 20000 / fixture_rarer; i++) {
        cam_speed_config_t cfg = config.play.speed;
        cfg.sense = i % 2 == 0 ? 1 : -1;
        const double from = random_real(&random, 0.25, 4.0);
        const double to = from + random_real(&random, -0.05, 0.05);
        const int32_t from_q28 = (int32_t)lround(ldexp(from, 28));
        const int32_t to_q28 = (int32_t)lround(ldexp(to, 28));
        const double lag = ldexp(cfg.lag_q16, -16);
        const double ratio = fmin(8.0, fmax(0.0, (from + to) / 2.0 + (to - from) * lag));
        const double mrpm = cfg.sense * fmin(cfg.mean_mrpm * ratio, cfg.limit_mrpm);
        TEST_ASSERT_DOUBLE_WITHIN(2.0 + 2e-6 * fabs(mrpm), mrpm,
                                  cam_speed_mrpm(&cfg, from_q28, to_q28));
        const double alpha = ldexp(cfg.mean_q32, -20) * (to_q28 - from_q28);
        TEST_ASSERT_DOUBLE_WITHIN(1.0, alpha, cam_speed_alpha_q40(&cfg, to_q28 - from_q28));
    }
}

/// A speed loop of first order that gets these set-points is at the ratio of every plan.
static void test_spindle_with_the_lag_reaches_the_ratio_at_every_plan(void)
{
    const cam_speed_config_t *cfg = &config.play.speed;
    const double share = exp(-1.0 / ldexp(cfg->lag_q16, -16));
    double speed = 200000.0;
    int32_t from_q28 = CAM_RATIO_ONE_Q28;
    for (int plan = 1; plan <= 2000; plan++) { // a triangle: the acceleration turns over
        const double ratio = 1.0 + 0.3 * fabs(fmod(plan / 127.3, 2.0) - 1.0) - 0.3;
        const int32_t to_q28 = (int32_t)lround(ldexp(ratio, 28));
        const double set = cam_speed_mrpm(cfg, from_q28, to_q28);
        speed = set + (speed - set) * share;
        from_q28 = to_q28;
        TEST_ASSERT_DOUBLE_WITHIN(200000.0 * 3e-5, 200000.0 * ratio, speed);
    }
}

static void test_ratio_is_eased_by_the_envelope(void)
{
    fixture_random_t random = {.state = 9};
    for (int i = 0; i < 20000 / fixture_rarer; i++) {
        const double ratio = random_real(&random, 0.0625, 4.0);
        const double envelope = random_real(&random, 0.0, 1.0);
        const int32_t found = cam_speed_eased_q28((int32_t)lround(ldexp(ratio, 28)),
                                                  (int32_t)lround(ldexp(envelope, 30)));
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, 1.0 + envelope * (ratio - 1.0), ldexp(found, -28));
    }
}

static void test_extremes_saturate_without_overflow(void)
{
    cam_speed_config_t cfg = config.play.speed;
    cfg.mean_mrpm = 60000000;
    cfg.limit_mrpm = 60000000;
    cfg.lag_q16 = INT32_MAX;
    cfg.mean_q32 = INT32_C(1) << 26;
    const int32_t low_q28 = INT32_C(1) << 24;
    const int32_t high_q28 = INT32_C(1) << 30;
    TEST_ASSERT_EQUAL_INT32(60000000, cam_speed_mrpm(&cfg, low_q28, high_q28));
    TEST_ASSERT_EQUAL_INT32(0, cam_speed_mrpm(&cfg, high_q28, low_q28));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, cam_speed_alpha_q40(&cfg, high_q28 - low_q28));
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, cam_speed_alpha_q40(&cfg, low_q28 - high_q28));
}
