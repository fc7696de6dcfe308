// SPDX-License-Identifier: Apache-2.0
// A set of parameters is right or wrong as a whole, whatever the order in which it is taken.
#include "fixture_rig.h"
#include "sim_config.h"
#include "unity.h"
#include <stdio.h>  // sscanf
#include <string.h> // strstr

static fixture_rig_t rig;
static fixture_part_t part;
static cam_params_t params;
static common_error_t error;

void setUp(void)
{
    part = fixture_part_short();
    fixture_rig_init(&rig, &part, 20000);
    params = rig.machine.params;
}

static bool apply(void)
{
    const bool is_taken = sim_params_apply(&rig.machine, &params, &error);
    fixture_rig_tick(&rig);
    return is_taken;
}

/// A slow U passes the gains of before, which the set makes smaller later.
static void test_set_is_taken_whose_first_part_is_wrong_alone(void)
{
    params.k1_ns = 0;
    params.k2_us2 = 200000;
    TEST_ASSERT_TRUE(apply());
    params.u_speed_um_per_s = 5000;
    params.k2_us2 = 1000;
    TEST_ASSERT_EQUAL_INT(cam_err_gain, fixture_rig_set(&rig, cam_param_u_speed_um_per_s, 5000));
    TEST_ASSERT_TRUE(apply());
    for (uint32_t i = 0; i < cam_n_params; i++) {
        const cam_param_id_t id = (cam_param_id_t)i;
        TEST_ASSERT_EQUAL_INT32(cam_param_get(&params, id), cam_param_get(&rig.machine.params, id));
    }
}

static void expect_refusal(const char *says)
{
    TEST_ASSERT_FALSE(apply());
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error.text, says), error.text);
}

/// The refusal names the gain, although the speed of U was set before it, and the accepted bound.
static void test_gain_that_is_wrong_in_the_whole_set_is_reported_with_its_bound(void)
{
    params.u_speed_um_per_s = 5000;
    params.k1_ns = 0;
    params.k2_us2 = 200000;
    expect_refusal(
        "parameter k2_us2 = 200000: refused: the command to U, feed-forward included, would "
        "exceed its limits; with the other parameters it is at most ");
    int bound = 0;
    TEST_ASSERT_EQUAL_INT(1, sscanf(strstr(error.text, "at most "), "at most %d", &bound));
    params.k2_us2 = bound + 1;
    TEST_ASSERT_FALSE(apply());
    params.k2_us2 = bound;
    TEST_ASSERT_TRUE(apply());
}

/// The acceleration named is the largest one with which a slow drive is taken.
static void test_slow_drive_is_refused_with_the_acceleration_it_needs(void)
{
    params.k2_us2 = 3505923; // 85 Hz
    expect_refusal("; it follows from [u] bandwidth_hz of the machine file unless it is set; such "
                   "a drive needs [u] acceleration_mm_per_s2 of at most ");
    int most = 0;
    const char *const place = strstr(error.text, "_s2 of at most ");
    TEST_ASSERT_EQUAL_INT(1, sscanf(place, "_s2 of at most %d", &most));
    params.u_acceleration_mm_per_s2 = most + 1;
    TEST_ASSERT_FALSE(apply());
    params.u_acceleration_mm_per_s2 = most;
    TEST_ASSERT_TRUE(apply());
}

static void test_drive_that_no_acceleration_helps_is_refused(void)
{
    params.u_speed_um_per_s = cam_param_info(cam_param_u_speed_um_per_s)->min;
    params.k2_us2 = 80000000;
    expect_refusal("this drive is too slow: give a larger bandwidth_hz");
}

static void test_jerk_is_reported_with_its_bound(void)
{
    params.u_jerk_m_per_s3 = 1;
    expect_refusal("parameter u_jerk_m_per_s3 = 1: refused: ");
    TEST_ASSERT_NOT_NULL(strstr(error.text, "it is at least "));
}

static void test_other_values_are_reported_by_the_refused_parameter(void)
{
    params.counts_per_turn = 0;
    expect_refusal("parameter counts_per_turn = 0: refused: ");
    params = rig.machine.params;
    params.observer_bandwidth_mHz = 100000000;
    expect_refusal("parameter observer_bandwidth_mHz = 100000000: refused: ");
}

/// The refusal of an earlier change is not repeated.
static void test_a_set_while_another_is_pending_is_refused_as_busy(void)
{
    const int32_t jerk_m_per_s3 = params.u_jerk_m_per_s3;
    params.u_jerk_m_per_s3 = 1;
    TEST_ASSERT_FALSE(apply());
    params.u_jerk_m_per_s3 = jerk_m_per_s3;
    TEST_ASSERT_TRUE(sim_params_apply(&rig.machine, &params, &error));
    TEST_ASSERT_FALSE(sim_params_apply(&rig.machine, &params, &error));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error.text, "parameters: refused: "), error.text);
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error.text, cam_err_text(cam_err_busy)), error.text);
}
