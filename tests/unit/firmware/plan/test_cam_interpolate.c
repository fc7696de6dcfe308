// SPDX-License-Identifier: Apache-2.0
// Equal increments of a set-point: they arrive exactly, and no target leads beyond the word of a
// place.
#include "cam_plan_move.h"
#include "unity.h"

enum { most_plan_ticks = 40 };

static cam_play_config_t cfg;

void setUp(void)
{
    cfg = (cam_play_config_t){.plan_ticks = 8, .per_plan_q30 = (1 << 30) / 8};
}

/// @return [nm / 1024] where the axis is at the next plan
static int64_t then_q10(const cam_axis_motion_t *m)
{
    return m->pos_q10 + (int64_t)m->vel_q10 * cfg.plan_ticks;
}

static void test_target_is_there_at_the_next_plan(void)
{
    for (int32_t ticks = 1; ticks <= most_plan_ticks; ticks += 3) {
        cfg.plan_ticks = ticks;
        cfg.per_plan_q30 = (1 << 30) / ticks;
        for (int64_t way_q10 = -100000; way_q10 <= 100000; way_q10 += 7777) {
            cam_axis_motion_t m = {.pos_q10 = 5000000, .vel_q10 = 99, .acc_q10 = 77};
            cam_plan_move_line_isr(&m, &cfg, 5000000 + way_q10);
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
    TEST_ASSERT_EQUAL_INT32(1, cam_plan_move_share(&cfg, 8));
    TEST_ASSERT_EQUAL_INT32(1, cam_plan_move_share(&cfg, 4));
    TEST_ASSERT_EQUAL_INT32(0, cam_plan_move_share(&cfg, 3));
    TEST_ASSERT_EQUAL_INT32(-1, cam_plan_move_share(&cfg, -5));
}

/// One that is further than 2^31 / 1024 nm, 2.1 mm, takes more than a plan.
static void test_far_target_is_followed_later(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        cam_axis_motion_t m = {.pos_q10 = 0};
        cam_plan_move_line_isr(&m, &cfg, sign * (INT64_C(1) << 40));
        TEST_ASSERT_EQUAL_INT64(sign > 0 ? INT32_MAX : INT32_MIN, then_q10(&m));
    }
}

static void test_no_target_leads_beyond_the_farthest_place(void)
{
    const int64_t most_q10 = INT64_C(2147000000) * 1024;
    for (int sign = -1; sign <= 1; sign += 2) {
        cam_axis_motion_t m = {.pos_q10 = sign * (most_q10 - 100)};
        cam_plan_move_line_isr(&m, &cfg, sign * (most_q10 - 1));
        TEST_ASSERT_EQUAL_INT64(sign * (most_q10 - 1), then_q10(&m));
        cam_plan_move_line_isr(&m, &cfg, sign * (most_q10 + 1));
        TEST_ASSERT_EQUAL_INT64(sign * most_q10, then_q10(&m));
        cam_plan_move_line_isr(&m, &cfg, sign * (INT64_C(1) << 60));
        TEST_ASSERT_EQUAL_INT64(sign * most_q10, then_q10(&m));
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
    cfg.table = &table;
    cfg.x_clearance_nm = 2000;
    cfg.x_offset_q10 = INT64_C(7000) * 1024;
    const int32_t full = 1 << 30;
    TEST_ASSERT_EQUAL_INT64(7030 * 1024, cam_plan_move_profile_q10(&cfg, 500000, full, 0));
    TEST_ASSERT_EQUAL_INT64(9030 * 1024, cam_plan_move_profile_q10(&cfg, 500000, 0, 0));
    TEST_ASSERT_EQUAL_INT64(7530 * 1024, cam_plan_move_profile_q10(&cfg, 500000, full / 4 * 3, 0));
    TEST_ASSERT_EQUAL_INT64(7030 * 1024 + 64, cam_plan_move_profile_q10(&cfg, 500000, full, 1));
    TEST_ASSERT_EQUAL_INT64(7030 * 1024 - 64, cam_plan_move_profile_q10(&cfg, 500000, full, -1));
}
