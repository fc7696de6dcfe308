// SPDX-License-Identifier: Apache-2.0
// A set of parameters is right or wrong as a whole, whatever the order in which it is taken.
#define OWN_SET_UP
#include "rig_bench.h"
#include "sim_config.h"
#include <stdio.h> // sscanf

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

/// The set must be refused with these words.
/// @return the bound that follows the words, 0 when there is none
static int expect_refusal(const char *words)
{
    int bound = 0;
    TEST_ASSERT_FALSE(apply());
    const char *const place = strstr(error.text, words);
    TEST_ASSERT_NOT_NULL_MESSAGE(place, error.text);
    (void)sscanf(place + strlen(words), "%d", &bound);
    return bound;
}

/// The bound that a refusal names is the last value that is taken.
static void expect_bound(int32_t *param, const char *words)
{
    const int bound = expect_refusal(words);
    *param = bound + 1;
    TEST_ASSERT_FALSE(apply());
    *param = bound;
    TEST_ASSERT_TRUE(apply());
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

/// The refusal names the gain, although the speed of U was set before it. The acceleration named is
/// the largest one with which a slow drive is taken.
static void test_gain_that_is_wrong_in_the_whole_set_is_reported_with_its_bound(void)
{
    params.k2_us2 = 3505923; // 85 Hz
    expect_bound(&params.u_acceleration_mm_per_s2,
                 "; it follows from [u] bandwidth_hz of the machine file unless it is set; such "
                 "a drive needs [u] acceleration_mm_per_s2 of at most ");
    setUp();
    params.u_speed_um_per_s = 5000;
    params.k1_ns = 0;
    params.k2_us2 = 200000;
    expect_bound(&params.k2_us2,
                 "parameter k2_us2 = 200000: refused: the command to U, feed-forward included, "
                 "would exceed its limits; with the other parameters it is at most ");
}

static void test_other_values_are_reported_by_the_refused_parameter(void)
{
    static const struct {
        int32_t *param, value;
        const char *words;
    } rows[] = {
        {&params.u_jerk_m_per_s3, 1, "parameter u_jerk_m_per_s3 = 1: refused: "},
        {&params.u_jerk_m_per_s3, 1, "it is at least "},
        {&params.counts_per_turn, 0, "parameter counts_per_turn = 0: refused: "},
        {&params.observer_bandwidth_mHz, 100000000,
         "parameter observer_bandwidth_mHz = 100000000: refused: "},
    };
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        params = rig.machine.params;
        *rows[i].param = rows[i].value;
        (void)expect_refusal(rows[i].words);
    }
    params = rig.machine.params;
    params.u_speed_um_per_s = cam_param_info(cam_param_u_speed_um_per_s)->min;
    params.k2_us2 = 80000000; // no acceleration helps
    (void)expect_refusal("this drive is too slow: give a larger bandwidth_hz");
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
