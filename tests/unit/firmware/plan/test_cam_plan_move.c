// SPDX-License-Identifier: Apache-2.0
// X and Z from plan to plan: what a motion takes over from the one before.
#include "cam_plan_move.h"
#include "unity.h"
#include <string.h> // memset

enum { nm = 1024, acceleration_nm = 500, speed_nm = 50000, log2_window = 3 };

static cam_motion_t motion;
static cam_play_config_t config;
static const cam_motion_limits_t limits = {speed_nm * nm, acceleration_nm *nm, log2_window};

void setUp(void)
{
    memset(&motion, 0, sizeof motion);
    memset(&config, 0, sizeof config);
    config.plan_ticks = 1;
    config.per_plan_q30 = INT32_C(1) << 30;
    motion.axis[hal_axis_x].vel_q10 = -700 * nm;
}

/// Plan until X rests, each tick with a plan.
/// @return [nm] how far X goes on before it turns round
static int64_t go_on_nm(int64_t place_nm)
{
    cam_axis_motion_t *x = &motion.axis[hal_axis_x];
    int64_t least_q10 = 0;
    bool is_there = false;
    for (int i = 0; i < 10000 && !is_there; i++) {
        is_there = cam_plan_move_to_isr(&motion, hal_axis_x, &config, &limits, place_nm * nm);
        motion.is_filtering = true;
        x->pos_q10 += x->vel_q10;
        least_q10 = x->pos_q10 < least_q10 ? x->pos_q10 : least_q10;
    }
    TEST_ASSERT_TRUE(is_there);
    TEST_ASSERT_EQUAL_INT64(place_nm * nm, x->pos_q10);
    return -least_q10 / nm;
}

static void test_motion_begins_with_speed_and_acceleration_of_the_axis(void)
{
    motion.change_q10[hal_axis_x] = -300 * nm;
    (void)cam_plan_move_to_isr(&motion, hal_axis_x, &config, &limits, 1000000 * nm);
    // The first plan goes on but for the jerk: 2 x 500 nm over the eight plans of the window.
    TEST_ASSERT_INT32_WITHIN(125 * nm, (-700 - 300) * nm, motion.axis[hal_axis_x].vel_q10);
}

/// A spindle that jumps drags X along at 13 times its acceleration. X goes on towards the work by
/// what it needs to turn its speed, and the acceleration that it may have, round: no more.
static void test_acceleration_beyond_the_limit_is_not_gone_on_with(void)
{
    motion.change_q10[hal_axis_x] = -acceleration_nm * nm;
    const int64_t allowed_nm = go_on_nm(1000000);
    setUp();
    motion.change_q10[hal_axis_x] = -6600 * nm;
    TEST_ASSERT_EQUAL_INT64(allowed_nm, go_on_nm(1000000));
    TEST_ASSERT_LESS_THAN_INT64(20000, allowed_nm);
    setUp();
    motion.axis[hal_axis_x].vel_q10 = 700 * nm;
    motion.change_q10[hal_axis_x] = 6600 * nm; // the other way likewise
    (void)cam_plan_move_brake_isr(&motion, hal_axis_x, &config, &limits);
    TEST_ASSERT_LESS_OR_EQUAL_INT32((700 + acceleration_nm) * nm, motion.axis[hal_axis_x].vel_q10);
}
