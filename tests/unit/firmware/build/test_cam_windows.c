// SPDX-License-Identifier: Apache-2.0
// Windows of the position switches, to the last digit of the interrupt's numbers.
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

/// Where the interrupt's angle falls with the drawing's, the window begins at its other end.
/// Several windows per turn are those of a faster angle, of which a quarter is all. The hysteresis
/// is at most a quarter of the window.
static void test_window_and_hysteresis_are_those_of_the_angles(void)
{
    static const struct {
        int32_t on_deg, off_deg, per_turn, sense, hysteresis_udeg;
        int32_t from_deg; ///< [1 deg of the faster angle]
        uint32_t width_q32, hysteresis_q32;
    } rows[] = {
        {10, 20, 1, 1, 0, 10, 119304647, 0},
        {10, 20, 1, -1, 1000000, 20, 119304647, per_degree_q32},
        {350, 10, 1, 1, 0, 350, 238609294, 0},
        {10, 9, 1, 1, 0, 10, 4283036831u, 0},
        {30, 30, 1, 1, 0, 30, 0, 0},
        {0, 360, 1, 1, 0, 0, UINT32_MAX, 0},
        {10, 20, 4, 1, 5000000, 40, 477218588, 29826161},
        {10, 110, 4, 1, 0, 40, UINT32_MAX, 0},
        {10, 20, 1, 1, 2499999, 10, 119304647, 29826150},
        {10, 20, 1, 1, 5000000, 10, 119304647, 29826161},
    };
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        between(rows[i].on_deg, rows[i].off_deg);
        params.switch_3_per_turn = rows[i].per_turn;
        params.switch_3_hysteresis_udeg = rows[i].hysteresis_udeg;
        const cam_switch_config_t c = built(rows[i].sense);
        const uint32_t slack = rows[i].per_turn == 1 ? 0 : 4;
        TEST_ASSERT_EQUAL_UINT32(rows[i].per_turn, c.per_turn);
        const uint32_t from_q32 = turn_q32(rows[i].from_deg);
        TEST_ASSERT_UINT32_WITHIN(slack, rows[i].sense > 0 ? from_q32 : 0u - from_q32, c.from_q32);
        TEST_ASSERT_UINT32_WITHIN(slack, rows[i].width_q32, c.width_q32);
        TEST_ASSERT_UINT32_WITHIN(slack, rows[i].hysteresis_q32, c.hysteresis_q32);
    }
}

/// A switch is commanded ahead by its dead time and by half a tick, for the middle of the tick.
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
