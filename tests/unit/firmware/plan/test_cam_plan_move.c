// SPDX-License-Identifier: Apache-2.0
// X and Z from plan to plan: equal increments that arrive exactly, targets beyond the word of a
// position, and the speed and acceleration that a motion continues from.
#include "cam_plan_inner.h"
#include "unity.h"
#include <string.h> // memset

enum { nm = 1024, acceleration_nm = 500, speed_nm = 50000, log2_window = 3 };

static cam_motion_t motion;
static cam_play_config_t config;
static const cam_motion_limits_t limits = {speed_nm * nm, acceleration_nm *nm, log2_window};

static void set_plan(int32_t ticks)
{
    config.plan_ticks = ticks;
    config.per_plan_q30 = (INT32_C(1) << 30) / ticks;
}

void setUp(void)
{
    memset(&motion, 0, sizeof motion);
    memset(&config, 0, sizeof config);
    set_plan(1);
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

/// @return [nm / 1024] where the axis is at the next plan
static int64_t then_q10(const cam_axis_motion_t *m)
{
    return m->pos_q10 + (int64_t)m->vel_q10 * config.plan_ticks;
}

static void test_target_is_there_at_the_next_plan(void)
{
    for (int32_t ticks = 1; ticks <= 40; ticks += 3) {
        set_plan(ticks);
        for (int64_t way_q10 = -100000; way_q10 <= 100000; way_q10 += 7777) {
            cam_axis_motion_t m = {.pos_q10 = 5000000, .vel_q10 = 99, .acc_q10 = 77};
            cam_plan_move_line_isr(&m, &config, 5000000 + way_q10);
            TEST_ASSERT_EQUAL_INT64(5000000 + way_q10, then_q10(&m));
            TEST_ASSERT_INT32_WITHIN(1, (int32_t)(way_q10 / ticks), m.vel_q10);
            TEST_ASSERT_EQUAL_INT32(0, m.acc_q10);
            TEST_ASSERT_INT64_WITHIN((uint32_t)ticks, 5000000,
                                     m.pos_q10); // what the division leaves
        }
    }
}

static void test_share_is_rounded_to_nearest(void)
{
    set_plan(8);
    TEST_ASSERT_EQUAL_INT32(1, cam_plan_move_share(&config, 8));
    TEST_ASSERT_EQUAL_INT32(1, cam_plan_move_share(&config, 4));
    TEST_ASSERT_EQUAL_INT32(0, cam_plan_move_share(&config, 3));
    TEST_ASSERT_EQUAL_INT32(-1, cam_plan_move_share(&config, -5));
}

/// A target further than 2^31 / 1024 nm, 2.1 mm, takes more than a plan; none is beyond the
/// farthest position.
static void test_target_is_limited_to_the_words_of_a_position(void)
{
    const int64_t far_q10 = INT64_C(2147000000) * 1024;
    const struct {
        int64_t from_q10, target_q10, then_q10;
    } rows[] = {{0, INT64_C(1) << 40, INT32_MAX},
                {far_q10 - 100, far_q10 - 1, far_q10 - 1},
                {far_q10 - 100, far_q10 + 1, far_q10},
                {far_q10 - 100, INT64_C(1) << 60, far_q10}};
    set_plan(8);
    for (uint32_t i = 0; i < 8u; i++) {
        const int64_t sign = i < 4u ? 1 : -1;
        cam_axis_motion_t m = {.pos_q10 = sign * rows[i % 4u].from_q10};
        cam_plan_move_line_isr(&m, &config, sign * rows[i % 4u].target_q10);
        TEST_ASSERT_EQUAL_INT64(i == 4u ? INT32_MIN : sign * rows[i % 4u].then_q10, then_q10(&m));
    }
}

/// A flat profile of 30 nm: the trim and, out of the work, the clearance are added.
static void test_x_has_its_trim_and_its_clearance(void)
{
    static const cam_knot_t knots[2] = {{.p = 30 * 16}, {.p = 30 * 16}};
    static cam_table_t table;
    table.x = (cam_channel_t){.knots = knots,
                              .n_slices = 2,
                              .frac_bits = 4,
                              .span_nm = 1000000,
                              .slices_per_nm_q48 = 281474977};
    config.table = &table;
    config.x_clearance_nm = 2000;
    config.x_offset_q10 = INT64_C(7000) * 1024;
    const int32_t full = 1 << 30;
    TEST_ASSERT_EQUAL_INT64(7030 * 1024, cam_plan_move_profile_q10(&config, 500000, full, 0));
    TEST_ASSERT_EQUAL_INT64(9030 * 1024, cam_plan_move_profile_q10(&config, 500000, 0, 0));
    TEST_ASSERT_EQUAL_INT64(7530 * 1024,
                            cam_plan_move_profile_q10(&config, 500000, full / 4 * 3, 0));
    TEST_ASSERT_EQUAL_INT64(7030 * 1024 + 64, cam_plan_move_profile_q10(&config, 500000, full, 1));
    TEST_ASSERT_EQUAL_INT64(7030 * 1024 - 64, cam_plan_move_profile_q10(&config, 500000, full, -1));
}
