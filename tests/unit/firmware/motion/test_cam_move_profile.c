// SPDX-License-Identifier: Apache-2.0
// To a place within speed and acceleration, from any start.
#include "cam_motion.h"
#include "fixture_random.h"
#include "unity.h"
#include <stdlib.h>

static const cam_motion_limits_t limits = {.speed_q10 = 2000000, .acceleration_q10 = 64000};

/// Move from rest at 0 to the target, within the limits of each step, and past the target by no
/// more than an eighth of the acceleration.
static void drive(const cam_motion_limits_t *l, int64_t target_q10)
{
    cam_axis_motion_t m = {0};
    bool is_there = false;
    for (uint32_t i = 0; i < 2000000u && !is_there; i++) {
        const cam_axis_motion_t before = m;
        is_there = cam_move_profile_to_isr(&m, l, target_q10);
        TEST_ASSERT_EQUAL_INT64(before.pos_q10 + m.vel_q10, m.pos_q10);
        TEST_ASSERT_EQUAL_INT32(m.vel_q10 - before.vel_q10, m.acc_q10);
        TEST_ASSERT_LESS_OR_EQUAL_INT32(l->acceleration_q10, abs(m.acc_q10));
        TEST_ASSERT_LESS_OR_EQUAL_INT32(l->speed_q10, abs(m.vel_q10));
        const int64_t past = target_q10 >= 0 ? m.pos_q10 - target_q10 : target_q10 - m.pos_q10;
        TEST_ASSERT_LESS_OR_EQUAL_INT64(l->acceleration_q10 / 8, past);
    }
    TEST_ASSERT_TRUE(is_there);
    TEST_ASSERT_EQUAL_INT64(target_q10, m.pos_q10);
    TEST_ASSERT_EQUAL_INT32(0, m.vel_q10);
}

/// The random limits are of any proportion: a step of acceleration may be above the speed.
static void test_move_from_rest_reaches_the_target_within_its_limits(void)
{
    static const int64_t targets[] = {0,       1,         -1,        63999,
                                      64000,   64001,     200000,    -999999,
                                      5000000, -70000000, 900000000, INT64_C(1) << 40};
    for (uint32_t i = 0; i < sizeof targets / sizeof targets[0]; i++) {
        drive(&limits, targets[i]);
    }
    drive(&(const cam_motion_limits_t){.speed_q10 = 1000, .acceleration_q10 = 5000}, 5000);
    fixture_random_t dice = {.state = 21};
    for (int i = 0; i < 20000 / fixture_rarer; i++) {
        const cam_motion_limits_t any = {.speed_q10 = (int32_t)fixture_random_range(&dice, 1, 2000),
                                         .acceleration_q10 =
                                             (int32_t)fixture_random_range(&dice, 1, 10000)};
        drive(&any, fixture_random_range(&dice, -20000, 20000));
    }
}

/// Each step takes the highest of faster, same and slower from which the axis can still brake: from
/// v that needs v (v + a) / 2a with the step itself.
static void test_move_takes_the_highest_speed_from_which_it_can_brake(void)
{
    enum { a = 64000, v = 10 * a, same_needs = 55 * a, faster_needs = 66 * a };
    static const struct {
        int32_t distance, from, vel;
    } cases[] = {{faster_needs, v, v + a},
                 {faster_needs - 1, v, v},
                 {same_needs, v, v},
                 {same_needs - 1, v, v - a},
                 {a + 1, a + 1, 1}};
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
            cam_axis_motion_t m = {.pos_q10 = 77, .vel_q10 = sign * cases[i].from};
            const int64_t target_q10 = 77 + (int64_t)sign * cases[i].distance;
            TEST_ASSERT_FALSE(cam_move_profile_to_isr(&m, &limits, target_q10));
            TEST_ASSERT_EQUAL_INT32(sign * cases[i].vel, m.vel_q10);
        }
    }
    const int32_t most = limits.speed_q10 - limits.speed_q10 % a; // a step more is beyond the limit
    cam_axis_motion_t m = {.vel_q10 = most};
    (void)cam_move_profile_to_isr(&m, &limits, INT64_C(1) << 40);
    TEST_ASSERT_EQUAL_INT32(limits.speed_q10, m.vel_q10);
    m.vel_q10 = limits.speed_q10 - a;
    (void)cam_move_profile_to_isr(&m, &limits, INT64_C(1) << 40);
    TEST_ASSERT_EQUAL_INT32(limits.speed_q10, m.vel_q10);
}

/// A speed that one step reaches: the last step is no faster, and a speed beyond the limit by less
/// than a step falls to the limit, not through 0.
static void test_move_slower_than_a_step_of_acceleration_keeps_its_speed(void)
{
    const cam_motion_limits_t slow = {.speed_q10 = 1000, .acceleration_q10 = 64000};
    cam_axis_motion_t m = {.vel_q10 = 1007};
    for (int i = 0; i < 200 && (m.pos_q10 != 60500 || m.vel_q10 != 0); i++) {
        (void)cam_move_profile_to_isr(&m, &slow, 60500);
        TEST_ASSERT_TRUE(m.vel_q10 >= 0 && m.vel_q10 <= slow.speed_q10);
    }
    TEST_ASSERT_EQUAL_INT64(60500, m.pos_q10);
}

static void test_stop_brakes_to_rest_wherever_that_is(void)
{
    static const int32_t speeds[] = {0, 1, -1, 64000, -64001, 2000000, -2000000};
    for (uint32_t i = 0; i < sizeof speeds / sizeof speeds[0]; i++) {
        cam_axis_motion_t m = {.vel_q10 = speeds[i]};
        uint32_t n = 0;
        int32_t last = abs(speeds[i]);
        while (!cam_move_profile_stop_isr(&m, &limits)) {
            TEST_ASSERT_LESS_THAN_INT32(last, abs(m.vel_q10));
            last = abs(m.vel_q10);
            n++;
        }
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(32, n);
        TEST_ASSERT_TRUE((int64_t)speeds[i] * m.pos_q10 >= 0);
    }
}
