// SPDX-License-Identifier: Apache-2.0
// To a place within speed, acceleration and jerk, from rest and from any motion, for many limits.
#include "cam_motion.h"
#include "fixture_random.h"
#include "unity.h"
#include <stdlib.h>

static cam_jerk_filter_t filter;

void setUp(void)
{
    filter = (cam_jerk_filter_t){0};
}

static int64_t larger(int64_t a, int64_t b)
{
    return a > b ? a : b;
}

/// What may not be exceeded on the way: the limits, or where the motion begins beyond them the
/// begin. A place is rounded by one unit, and so its second difference by four.
typedef struct {
    cam_motion_limits_t limits;
    int64_t most_vel_q10, most_acc_q10;
} bound_t;

static bound_t bound_of(const cam_motion_limits_t *limits, const cam_axis_motion_t *m)
{
    const int64_t n = INT64_C(1) << limits->log2_window;
    const int64_t bend = larger(limits->acceleration_q10, labs((long)m->acc_q10)) * n / 2;
    const int64_t first = labs((long)m->vel_q10) + (m->acc_q10 != 0 ? bend : 0);
    return (bound_t){*limits, larger(limits->speed_q10, first) + 1,
                     larger(limits->acceleration_q10, labs((long)m->acc_q10))};
}

/// Assert that a step keeps the bound, that its speed is the difference of its positions, and its
/// acceleration that of its speeds.
static void check_step(const bound_t *b, const cam_axis_motion_t *before,
                       const cam_axis_motion_t *now)
{
    const int64_t n = INT64_C(1) << b->limits.log2_window;
    TEST_ASSERT_EQUAL_INT64(now->pos_q10 - before->pos_q10, now->vel_q10);
    TEST_ASSERT_INT64_WITHIN(4, now->vel_q10 - before->vel_q10, now->acc_q10);
    TEST_ASSERT_LESS_OR_EQUAL_INT64(b->most_vel_q10 + 1, labs((long)now->vel_q10));
    TEST_ASSERT_LESS_OR_EQUAL_INT64(b->most_acc_q10 + 1, labs((long)now->acc_q10));
    const int64_t jerk = labs((long)now->acc_q10 - before->acc_q10);
    TEST_ASSERT_LESS_OR_EQUAL_INT64(2 * b->most_acc_q10 / n + 2, jerk);
}

static bool move(cam_axis_motion_t *m, const cam_motion_limits_t *limits, bool is_braked,
                 int64_t target_q10)
{
    return is_braked ? cam_jerk_filter_stop_isr(&filter, m, limits)
                     : cam_jerk_filter_to_isr(&filter, m, limits, target_q10);
}

/// Move to a target, or brake, and check every step. @return largest travel beyond the target
static int64_t drive(cam_axis_motion_t *m, const cam_motion_limits_t *limits, bool is_braked,
                     int64_t target_q10)
{
    enum { patience = 400000 };
    const bound_t bound = bound_of(limits, m);
    const bool was_below = m->pos_q10 <= target_q10;
    int64_t beyond = 0;
    bool is_there = false;
    for (int i = 0; i < patience && !is_there; i++) {
        const cam_axis_motion_t before = *m;
        is_there = move(m, limits, is_braked, target_q10);
        check_step(&bound, &before, m);
        const int64_t past = was_below ? m->pos_q10 - target_q10 : target_q10 - m->pos_q10;
        beyond = larger(beyond, past);
    }
    TEST_ASSERT_TRUE(is_there);
    TEST_ASSERT_EQUAL_INT32(0, m->vel_q10);
    const int64_t end_q10 = is_braked ? m->pos_q10 : target_q10;
    for (int i = 0; i < 3; i++) { // and it stays there
        TEST_ASSERT_EQUAL_INT64(end_q10, m->pos_q10);
        TEST_ASSERT_TRUE(move(m, limits, is_braked, target_q10));
    }
    TEST_ASSERT_EQUAL_INT32(0, m->acc_q10);
    return beyond;
}

/// Speeds above and below the acceleration, so that a step may be all of the speed.
static cam_motion_limits_t random_limits(fixture_random_t *dice)
{
    const uint32_t log2_window = (uint32_t)fixture_random_range(dice, 0, cam_jerk_filter_most_log2);
    const int32_t speed = (int32_t)fixture_random_range(dice, 1000, 3000000);
    const int32_t most = cam_jerk_filter_most_q10(log2_window);
    const int32_t wanted = (int32_t)fixture_random_range(dice, speed / 200 + 1, 4 * speed);
    const int32_t acceleration = wanted < most ? wanted : most;
    return (cam_motion_limits_t){speed, acceleration, log2_window};
}

/// From rest it passes its target by little; from any motion, too, it ends there, or brakes.
static void test_glide_keeps_every_limit_and_lands_exactly(void)
{
    fixture_random_t dice = {.state = 7};
    for (int i = 0; i < 4500; i++) {
        const bool is_at_rest = i % 4 == 0;
        const cam_motion_limits_t limits = random_limits(&dice);
        const int32_t v = is_at_rest ? 0 : limits.speed_q10;
        const int32_t a = is_at_rest ? 0 : limits.acceleration_q10;
        cam_axis_motion_t m = {
            .pos_q10 = fixture_random_range(&dice, -1000000000, 1000000000),
            .vel_q10 = (int32_t)fixture_random_range(&dice, -v, v),
            .acc_q10 = (int32_t)fixture_random_range(&dice, -a, a),
        };
        cam_jerk_filter_begin_isr(&filter, &m, limits.log2_window);
        const int64_t way = fixture_random_range(&dice, -200, 200) * limits.speed_q10 +
                            fixture_random_range(&dice, -1000, 1000);
        const int64_t beyond = drive(&m, &limits, i % 4 == 1, m.pos_q10 + way);
        TEST_ASSERT_TRUE(!is_at_rest || beyond <= limits.acceleration_q10 / 8 + 1);
    }
}

/// At rest from the begin it is still for a whole window; in motion it is not.
static void test_glide_that_begins_at_rest_is_still(void)
{
    static const int32_t cases[][2] = {{0, 0}, {1, 0}, {0, 1}, {5, -5}};
    for (int i = 0; i < 4; i++) {
        const cam_axis_motion_t m = {.vel_q10 = cases[i][0], .acc_q10 = cases[i][1]};
        cam_jerk_filter_begin_isr(&filter, &m, 3);
        TEST_ASSERT_EQUAL_UINT32(i == 0 ? 8 : 0, filter.n_still);
    }
}

/// A second method: the mean over places of cam_motion.h, the line of the past included.
static void test_glide_is_the_mean_of_the_last_places(void)
{
    enum { n = 16, steps = 400 };
    static const cam_motion_limits_t limits = {300000, 5000, 4};
    static int64_t place[n + steps];
    cam_axis_motion_t m = {.pos_q10 = 123456789, .vel_q10 = 200000, .acc_q10 = -2000};
    cam_jerk_filter_begin_isr(&filter, &m, limits.log2_window);
    place[n - 1] = filter.raw.pos_q10;
    for (int i = n - 1; i > 0; i--) { // the newest speed of the line is half of the window younger
        place[i - 1] = place[i] - (200000 - 2000 * (i - n / 2) + 1000 - 2000);
    }
    cam_axis_motion_t raw = filter.raw;
    for (int i = 0; i < steps; i++) {
        (void)cam_move_profile_to_isr(&raw, &limits, 50000000);
        place[n + i] = raw.pos_q10;
        (void)cam_jerk_filter_to_isr(&filter, &m, &limits, 50000000);
        int64_t sum = 0;
        for (int k = 0; k < n; k++) {
            sum += place[n + i - k];
        }
        TEST_ASSERT_EQUAL_INT64(sum >> 4, m.pos_q10);
    }
}

/// Another window counts from the next rest on, and other numbers of the axis at once.
static void test_glide_takes_another_window_at_rest_and_other_numbers_at_once(void)
{
    cam_motion_limits_t limits = {200000, 8000, 3};
    cam_axis_motion_t m = {0};
    cam_jerk_filter_begin_isr(&filter, &m, 3);
    for (int i = 0; i < 30; i++) {
        (void)cam_jerk_filter_to_isr(&filter, &m, &limits, 50000000);
    }
    limits.log2_window = 5;
    const int64_t before_q10 = m.pos_q10;
    cam_jerk_filter_shift_isr(&filter, 1000000);
    m.pos_q10 += 1000000;
    (void)cam_jerk_filter_to_isr(&filter, &m, &limits, 51000000);
    TEST_ASSERT_EQUAL_UINT32(3, filter.log2_window);
    TEST_ASSERT_INT64_WITHIN((uint64_t)limits.speed_q10, before_q10 + 1000000, m.pos_q10);
    while (!cam_jerk_filter_to_isr(&filter, &m, &limits, 51000000)) {
        TEST_ASSERT_EQUAL_UINT32(3, filter.log2_window);
    }
    (void)cam_jerk_filter_to_isr(&filter, &m, &limits, 51000000);
    TEST_ASSERT_EQUAL_UINT32(5, filter.log2_window);
    (void)drive(&m, &limits, false, 0);
}
