// SPDX-License-Identifier: Apache-2.0
// Angles and parameters in the units of the interrupt: rounded to nearest, saturated, wrapped.
#include "cam_build.h" // cam_units_scale, cam_units_ticks2_of_us2, cam_units_ticks_of_ns
#include "cam_fix.h"
#include "unity.h"

static void test_share_is_rounded_to_nearest_half_up(void)
{
    static const int64_t thirds[] = {0, 0, 1, 1, 1, 2, 2, 2, 3};
    static const int64_t quarters[] = {0, 0, 1, 1, 1, 1, 2, 2, 2};
    for (int64_t a = 0; a < 9; a++) {
        TEST_ASSERT_EQUAL_INT64(thirds[a], cam_units_scale(a, 1, 3));
        TEST_ASSERT_EQUAL_INT64(quarters[a], cam_units_scale(a, 1, 4));
        TEST_ASSERT_EQUAL_INT64(quarters[a], cam_units_scale(a, 5, 20));
    }
}

/// 2^32 / 360e6 is 11.93.
static void test_micro_degrees_become_a_part_of_a_turn(void)
{
    static const int32_t cases[][2] = {{0, 0},
                                       {1, 12},
                                       {-1, -12},
                                       {1000, 11930},
                                       {-1000, -11930},
                                       {90000000, 1 << 30},
                                       {-90000000, -(1 << 30)}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        TEST_ASSERT_EQUAL_INT32(cases[i][1], cam_units_turn_of_udeg(cases[i][0]));
    }
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, cam_units_turn_of_udeg(180000000));
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, cam_units_turn_of_udeg(-180000000));
    TEST_ASSERT_EQUAL_INT32(11930, cam_units_turn_of_mdeg(1));
    TEST_ASSERT_EQUAL_INT32(35791, cam_units_turn_of_mdeg(3));
    TEST_ASSERT_EQUAL_INT32(1 << 30, cam_units_turn_of_mdeg(90000));
}

/// At 20 kHz a tick has 50 us, its square 2500 us^2.
static void test_times_become_ticks(void)
{
    TEST_ASSERT_EQUAL_INT32(1 << 16, cam_units_ticks_of_ns(50000, 20000));
    TEST_ASSERT_EQUAL_INT32(1, cam_units_ticks_of_ns(1, 20000));
    TEST_ASSERT_EQUAL_INT32(0, cam_units_ticks_of_ns(1, 7000));
    TEST_ASSERT_EQUAL_INT32(1 << 16, cam_units_ticks2_of_us2(2500, 20000));
    TEST_ASSERT_EQUAL_INT32(26, cam_units_ticks2_of_us2(1, 20000));
    TEST_ASSERT_EQUAL_INT32(262144, cam_units_ticks2_of_us2(1000000, 2000));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, cam_units_ticks_of_ns(INT32_MAX, 20000));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, cam_units_ticks2_of_us2(1000000, 200000));
}

static void test_next_turn_is_at_a_position_or_behind_it(void)
{
    for (int64_t turn = -3; turn <= 3; turn++) {
        const int64_t at_q32 = turn * CAM_TURN_Q32;
        TEST_ASSERT_EQUAL_INT64(at_q32, cam_angle_next_turn(at_q32));
        TEST_ASSERT_EQUAL_INT64(at_q32 + CAM_TURN_Q32, cam_angle_next_turn(at_q32 + 1));
        TEST_ASSERT_EQUAL_INT64(at_q32, cam_angle_next_turn(at_q32 - 1));
        TEST_ASSERT_EQUAL_HEX32(5, cam_angle_of_pos(at_q32 + 5));
        TEST_ASSERT_EQUAL_HEX32(UINT32_MAX, cam_angle_of_pos(at_q32 - 1));
    }
}
