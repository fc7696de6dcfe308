// SPDX-License-Identifier: Apache-2.0
#include "cam_scope.h"
#include "unity.h"

static bool fires(cam_trigger_t t, int32_t last, int32_t now)
{
    return cam_trigger_fires(&t, (cam_trigger_last_t){.is_there = true, .value = last}, now);
}

static cam_trigger_t level(int32_t at, bool falls)
{
    return (cam_trigger_t){.kind = cam_trigger_level, .level = at, .falls = falls};
}

static cam_trigger_t angle(uint32_t at_q32, bool falls)
{
    return (cam_trigger_t){.kind = cam_trigger_angle, .level = (int32_t)at_q32, .falls = falls};
}

/// All steps between nine values about the level: exactly those that reach it fire.
static void test_level_fires_where_it_is_reached_and_not_beyond(void)
{
    static const int32_t levels[] = {0, 7, -7, INT32_MAX, INT32_MIN + 1};
    for (uint32_t i = 0; i < sizeof levels / sizeof levels[0]; i++) {
        for (int64_t a = -4; a <= 4; a++) {
            for (int64_t b = -4; b <= 4; b++) {
                const int64_t last = levels[i] + a;
                const int64_t now = levels[i] + b;
                if (last != (int32_t)last || now != (int32_t)now) {
                    continue;
                }
                TEST_ASSERT_EQUAL(a < 0 && b >= 0,
                                  fires(level(levels[i], false), (int32_t)last, (int32_t)now));
                TEST_ASSERT_EQUAL(a > 0 && b <= 0,
                                  fires(level(levels[i], true), (int32_t)last, (int32_t)now));
            }
        }
    }
}

/// Turns at steps that divide the turn and steps that do not, in both senses: one pass per turn, in
/// the first tick that is at the angle or behind it.
static void test_angle_fires_once_per_turn_in_its_sense_alone(void)
{
    static const uint32_t steps[] = {1u << 24, 16777259u, 715827883u, 2147483647u, 999999937u};
    static const uint32_t angles[] = {0u, 1u, 1u << 31, 3000000000u, UINT32_MAX};
    for (uint32_t i = 0; i < 25u; i++) {
        const uint32_t step = steps[i % 5u];
        const uint32_t at = angles[i / 5u];
        const uint32_t from = at - step / 3u;
        uint32_t n_up = 0;
        uint32_t n_down = 0;
        for (uint32_t k = 0; k < 1000u; k++) {
            const uint32_t last = from + k * step;
            const bool is_up = fires(angle(at, false), (int32_t)last, (int32_t)(last + step));
            TEST_ASSERT_EQUAL(at - last - 1u < step, is_up);
            n_up += is_up ? 1u : 0u;
            n_down += fires(angle(at, true), (int32_t)last, (int32_t)(last + step)) ? 1u : 0u;
            TEST_ASSERT_EQUAL(
                at - last - 1u < step,
                fires(angle(0u - at, true), (int32_t)(0u - last), (int32_t)(0u - last - step)));
        }
        const uint64_t way = (uint64_t)step * 1000u - step / 3u; // behind the first pass
        TEST_ASSERT_EQUAL_UINT32(1u + (uint32_t)(way >> 32), n_up);
        TEST_ASSERT_EQUAL_UINT32(0, n_down);
    }
}

/// From whichever state, and not while it lasts.
static void test_state_fires_from_any_other_state(void)
{
    for (int32_t to = 0; to < 5; to++) {
        const cam_trigger_t t = {.kind = cam_trigger_state, .level = to};
        for (int32_t last = 0; last < 5; last++) {
            for (int32_t now = 0; now < 5; now++) {
                TEST_ASSERT_EQUAL(now == to && last != to, fires(t, last, now));
            }
        }
    }
}

static void test_fault_fires_for_a_new_bit_of_the_mask(void)
{
    const cam_trigger_t any = {.kind = cam_trigger_fault};
    const cam_trigger_t third = {.kind = cam_trigger_fault, .level = 1 << 3};
    TEST_ASSERT_TRUE(fires(any, 0, 1));
    TEST_ASSERT_TRUE(fires(any, 1, 3));
    TEST_ASSERT_TRUE(fires(any, 0, INT32_MIN));
    TEST_ASSERT_FALSE(fires(any, 3, 3));
    TEST_ASSERT_FALSE(fires(any, 3, 1));
    TEST_ASSERT_TRUE(fires(third, 1, 9));
    TEST_ASSERT_FALSE(fires(third, 8, 15));
    TEST_ASSERT_FALSE(fires(third, 0, 7));
}

static void test_time_and_now_need_no_tick_before(void)
{
    const cam_trigger_last_t none = {.is_there = false};
    const cam_trigger_t now = {.kind = cam_trigger_now};
    const cam_trigger_t time = {.kind = cam_trigger_time, .level = 100};
    TEST_ASSERT_TRUE(cam_trigger_fires(&now, none, 0));
    TEST_ASSERT_FALSE(cam_trigger_fires(&time, none, 99));
    TEST_ASSERT_TRUE(cam_trigger_fires(&time, none, 100));
    TEST_ASSERT_TRUE(cam_trigger_fires(&time, none, 105));
}

static void test_a_first_tick_is_no_change(void)
{
    for (int32_t kind = cam_trigger_level; kind < (int32_t)cam_trigger_n; kind++) {
        const cam_trigger_t t = {.kind = (cam_trigger_kind_t)kind, .level = 1};
        TEST_ASSERT_FALSE(cam_trigger_fires(&t, (cam_trigger_last_t){0}, 1));
    }
}
