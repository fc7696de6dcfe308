// SPDX-License-Identifier: Apache-2.0
#include "fixture_image.h"
#include "sim_config.h"
#include "sim_units.h" // SIM_PI, SIM_TWO_PI
#include "unity.h"
#include <math.h>   // atan, sqrt, tan
#include <string.h> // strstr

/// The modulated part's ratio at the bottom: 1.05 + 0.375 cos 2 theta.
#define MEAN_RATIO 1.05
#define SWING 0.375
#define LEAST_RATIO (MEAN_RATIO - SWING)

static fixture_image_t image;
static cam_table_t table;
static cam_params_t params;
static common_error_t error;

void setUp(void)
{
    const fixture_part_t part = fixture_part_modulated();
    fixture_image_make(&image, &part);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_table_check(image.bytes, image.size, &table));
    params = cam_param_defaults();
}

static bool check(double mean_rpm, uint32_t highest_mrpm)
{
    const cam_refusal_t f = {.speed_mrpm = (uint32_t)(mean_rpm * 1e3 + 0.5),
                             .highest_mrpm = highest_mrpm};
    return sim_slow_check(&table, &params, &f, &error);
}

static void expect_refusal(double mean_rpm, uint32_t highest_mrpm, const char *why)
{
    TEST_ASSERT_FALSE(check(mean_rpm, highest_mrpm));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error.text, why), error.text);
}

static void test_slow_part_of_a_turn_lasts_as_long_as_its_integral(void)
{
    const double mean_rpm = 5.0 / (MEAN_RATIO - 0.5 * SWING); // slow while cos 2 theta < -1/2
    const double root = sqrt(MEAN_RATIO * MEAN_RATIO - SWING * SWING);
    const double share = sqrt(LEAST_RATIO / (MEAN_RATIO + SWING));
    const double rad = 2.0 / root * (SIM_PI / 2.0 - atan(share * tan(SIM_PI / 3.0)));
    const double exact_s = rad / (mean_rpm * SIM_TWO_PI / 60.0);
    const double longest_s = sim_slow_longest_s(&table, &params, mean_rpm);
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * exact_s, exact_s, longest_s);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, sim_slow_longest_s(&table, &params, 5.01 / LEAST_RATIO));
}

static void test_mean_speed_at_which_homing_never_ends_is_refused(void)
{
    expect_refusal(4.0, 600000,
                   "--rpm 4: below 5 (stopped_mrpm) the spindle counts as stopped; give "
                   "at least --rpm 7.5, or --set stopped_mrpm=2699");
    expect_refusal(4.0, 7400, // no speed that the machine cannot reach is a remedy
                   "; make the table for a faster spindle, or --set stopped_mrpm=2699");
    params.stopped_mrpm = 2699;
    TEST_ASSERT_TRUE(check(4.0, 600000));
}

static void test_slow_part_may_last_as_long_as_the_parameter_allows(void)
{
    const double longest_s = sim_slow_longest_s(&table, &params, 6.0);
    params.stopped_ms = (int32_t)(longest_s * 1e3) + 1;
    TEST_ASSERT_TRUE(check(6.0, 600000));
    params.stopped_ms -= 1;
    expect_refusal(6.0, 600000, "--rpm 6: in a turn it falls to 4.05, and for");
    TEST_ASSERT_TRUE(check(7.5, 600000));
}

static void test_uniform_speed_is_compared_with_the_parameter(void)
{
    const fixture_part_t part = fixture_part_short();
    fixture_image_make(&image, &part);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_table_check(image.bytes, image.size, &table));
    TEST_ASSERT_TRUE(check(5.0, 600000));
    expect_refusal(4.999, 600000, "at least --rpm 5.0, or --set stopped_mrpm=4999");
}
