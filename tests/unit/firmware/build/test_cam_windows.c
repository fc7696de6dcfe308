// SPDX-License-Identifier: Apache-2.0
// Windows of the position switches, to the last digit of what the interrupt gets of them.
#include "cam_build_inner.h"
#include "unity.h"

enum { tick_hz = 20000, per_degree_q32 = 11930465 };

static cam_params_t params;

void setUp(void)
{
    params = cam_param_defaults();
}

/// One window per turn of the third output, in degrees.
static void between(int32_t on_deg, int32_t off_deg)
{
    params.switch_3_per_turn = 1;
    params.switch_3_on_udeg = on_deg * 1000000;
    params.switch_3_off_udeg = off_deg * 1000000;
}

static cam_switch_config_t built(int32_t sense)
{
    const cam_switches_config_t all = cam_windows_build(&params, sense, tick_hz);
    TEST_ASSERT_EQUAL_UINT32(3, all.n);
    TEST_ASSERT_EQUAL_UINT32(0, all.each[0].per_turn);
    return all.each[2];
}

/// @return [turn / 2^32] of degrees, modulo a turn
static uint32_t turn_q32(int32_t degrees)
{
    return (uint32_t)(uint64_t)(((int64_t)degrees * 4294967296 + 180) / 360);
}

static void test_outputs_up_to_the_last_in_use_are_built(void)
{
    TEST_ASSERT_EQUAL_UINT32(0, cam_windows_build(&params, 1, tick_hz).n);
    params.switch_1_per_turn = 1;
    TEST_ASSERT_EQUAL_UINT32(1, cam_windows_build(&params, 1, tick_hz).n);
    params.switch_8_per_turn = 1;
    TEST_ASSERT_EQUAL_UINT32(8, cam_windows_build(&params, 1, tick_hz).n);
}

static void test_window_is_as_wide_as_from_its_one_end_to_its_other(void)
{
    between(10, 20);
    TEST_ASSERT_EQUAL_UINT32(turn_q32(10), built(1).width_q32);
    between(350, 10);
    TEST_ASSERT_EQUAL_UINT32(turn_q32(20), built(1).width_q32);
    between(10, 9);
    TEST_ASSERT_EQUAL_UINT32(turn_q32(359), built(1).width_q32);
    between(30, 30);
    TEST_ASSERT_EQUAL_UINT32(0, built(1).width_q32);
    between(0, 360);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, built(1).width_q32);
}

/// Where the interrupt's angle falls with the drawing's, the window begins at its other end.
static void test_window_begins_at_the_end_that_is_passed_first(void)
{
    between(10, 20);
    TEST_ASSERT_EQUAL_UINT32(turn_q32(10), built(1).from_q32);
    TEST_ASSERT_EQUAL_UINT32(0u - turn_q32(20), built(-1).from_q32);
    TEST_ASSERT_EQUAL_UINT32(turn_q32(10), built(-1).width_q32);
}

static void test_several_windows_per_turn_are_those_of_a_faster_angle(void)
{
    between(10, 20);
    params.switch_3_per_turn = 4;
    const cam_switch_config_t c = built(1);
    TEST_ASSERT_EQUAL_UINT32(4, c.per_turn);
    TEST_ASSERT_UINT32_WITHIN(4, turn_q32(40), c.from_q32);
    TEST_ASSERT_UINT32_WITHIN(4, turn_q32(40), c.width_q32);
    between(10, 110);
    params.switch_3_per_turn = 4; // more than a quarter of a turn is all of it
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, built(1).width_q32);
}

static void test_hysteresis_is_at_most_a_quarter_of_the_window(void)
{
    between(10, 20);
    params.switch_3_hysteresis_udeg = 1000000;
    TEST_ASSERT_EQUAL_UINT32(per_degree_q32, built(1).hysteresis_q32);
    params.switch_3_hysteresis_udeg = 2499999;
    TEST_ASSERT_UINT32_WITHIN(13, turn_q32(10) / 4u - 12u, built(1).hysteresis_q32);
    params.switch_3_hysteresis_udeg = 5000000;
    TEST_ASSERT_EQUAL_UINT32(turn_q32(10) / 4u, built(1).hysteresis_q32);
    params.switch_3_per_turn = 4;
    TEST_ASSERT_EQUAL_UINT32(turn_q32(10) / 4u, built(1).hysteresis_q32);
    params.switch_3_hysteresis_udeg = 0;
    TEST_ASSERT_EQUAL_UINT32(0, built(1).hysteresis_q32);
}

/// A switch is told ahead by its dead time and by half of a tick, for the middle of that.
static void test_dead_time_and_half_a_tick_are_looked_ahead(void)
{
    between(10, 20);
    TEST_ASSERT_EQUAL_INT32(32768, built(1).ahead_q16);
    params.switch_3_dead_time_ns = 150000;
    TEST_ASSERT_EQUAL_INT32(3 * 65536 + 32768, built(1).ahead_q16);
}

static void test_heights_and_sense_are_passed_on(void)
{
    between(10, 20);
    TEST_ASSERT_TRUE(built(1).is_anywhere);
    params.switch_3_z_low_nm = -5;
    params.switch_3_z_high_nm = 7;
    params.switch_3_sense = -1;
    const cam_switch_config_t c = built(1);
    TEST_ASSERT_FALSE(c.is_anywhere);
    TEST_ASSERT_EQUAL_INT32(-5, c.z_low_nm);
    TEST_ASSERT_EQUAL_INT32(7, c.z_high_nm);
    TEST_ASSERT_EQUAL_INT32(-1, c.sense);
}
