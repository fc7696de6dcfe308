// SPDX-License-Identifier: Apache-2.0
// Homing of a U that takes forces by its stop: plans of cam_jog.h with readings and forces of this
// test.
#include "cam_jog.h"
#include "unity.h"

enum { end_nm = 500000, press_q6 = 64000, still_plans = 50 };

static cam_jog_t h;
static cam_motion_t m;
static cam_tick_record_t r;
static cam_play_config_t cfg;
static int32_t sense;

static void begin(int32_t sense_, bool has_index)
{
    const cam_motion_limits_t limits = {.speed_q10 = 4096, .acceleration_q10 = 64};
    sense = sense_;
    h = (cam_jog_t){0};
    m = (cam_motion_t){.state = cam_state_manual};
    r = (cam_tick_record_t){.in.inputs = hal_in_drive_ready};
    cfg = (cam_play_config_t){
        .plan_ticks = 8,
        .per_plan_q30 = 1 << 27,
        .jog = {.u_end_q10 = end_nm * INT64_C(1024), .limits = {limits, limits, limits}}};
    cfg.jog.order = (cam_jog_order_t){.serial = 1,
                                      .until = 100000,
                                      .begin = cam_jog_search,
                                      .axis = hal_axis_u,
                                      .sense = sense,
                                      .has_index = has_index,
                                      .speed_q10 = 4096,
                                      .slow_q10 = 512,
                                      .low_q10 = -end_nm * INT64_C(1024),
                                      .high_q10 = end_nm * INT64_C(1024),
                                      .distance_q10 = 2 * end_nm * INT64_C(1024),
                                      .home_nm = sense * 550000,
                                      .press_q6 = press_q6,
                                      .still_plans = still_plans};
}

/// A plan; the next reading has the new origin.
static int32_t plan(void)
{
    const int32_t shift_nm = cam_jog_isr(&h, &cfg, &r, &m);
    r.in.actual_nm[hal_axis_u] += shift_nm;
    return shift_nm;
}

/// Let U press and stand. @return plans in which the phase was still the search
static int press(int32_t force_q6, int n)
{
    int k = 0;
    r.force_q6 = sense * force_q6;
    while (k < n && h.phase == cam_jog_search) {
        (void)plan();
        k++;
    }
    return k;
}

/// Bring U and its set-point to a distance from where it is, moving back.
static void go_back(int32_t by_nm)
{
    r.in.actual_nm[hal_axis_u] -= sense * by_nm;
    m.axis[hal_axis_u].pos_q10 = (int64_t)r.in.actual_nm[hal_axis_u] * 1024;
    m.axis[hal_axis_u].vel_q10 = -sense * 512;
    r.force_q6 = 0;
}

static void test_stop_is_found_when_u_stands_under_its_largest_force(void)
{
    for (int side = -1; side <= 1; side += 2) {
        begin(side, false);
        TEST_ASSERT_EQUAL_INT32(-side * end_nm, plan()); // its whole stroke is ahead
        TEST_ASSERT_EQUAL_INT32(press_q6, m.u_press_q6);
        TEST_ASSERT_EQUAL_INT(1000, press(press_q6 - 1, 1000));
        TEST_ASSERT_EQUAL_INT(1000, press(-press_q6, 1000));
        TEST_ASSERT_INT_WITHIN(1, still_plans, press(press_q6, 1000));
        TEST_ASSERT_EQUAL_INT(cam_jog_release, h.phase);
        TEST_ASSERT_EQUAL_HEX32(0, h.homed);
    }
}

static void test_u_that_moves_or_gives_way_is_not_at_its_stop_yet(void)
{
    begin(1, false);
    (void)plan();
    TEST_ASSERT_EQUAL_INT(still_plans - 1, press(press_q6, still_plans - 1));
    r.in.actual_nm[hal_axis_u] += 1001;
    TEST_ASSERT_EQUAL_INT(still_plans - 1, press(press_q6, still_plans - 1));
    TEST_ASSERT_EQUAL_INT(1, press(press_q6 - 1, 1));
    TEST_ASSERT_INT_WITHIN(1, still_plans, press(press_q6, 1000));
    TEST_ASSERT_EQUAL_INT(cam_jog_release, h.phase);
}

/// The stop is beyond the stroke: U has a home as soon as it is within.
static void test_home_is_where_u_stood_and_is_taken_within_the_stroke(void)
{
    for (int side = -1; side <= 1; side += 2) {
        begin(side, false);
        (void)plan();
        (void)press(press_q6, 1000);
        go_back(49000);
        (void)plan();
        TEST_ASSERT_EQUAL_INT(cam_jog_release, h.phase);
        TEST_ASSERT_EQUAL_INT32(press_q6, m.u_press_q6);
        go_back(2000);
        (void)plan();
        TEST_ASSERT_EQUAL_INT(cam_jog_done, h.end);
        TEST_ASSERT_EQUAL_INT32(side * (550000 - 51000), r.in.actual_nm[hal_axis_u]);
        TEST_ASSERT_EQUAL_INT32(0, m.u_press_q6);
    }
}

static void test_stop_is_left_after_ten_micrometres_back(void)
{
    begin(1, false);
    cfg.jog.order.home_nm = 300000;
    (void)plan();
    (void)press(press_q6, 1000);
    go_back(9999);
    (void)plan();
    TEST_ASSERT_EQUAL_INT(cam_jog_release, h.phase);
    go_back(1);
    (void)plan();
    TEST_ASSERT_EQUAL_INT(cam_jog_done, h.end);
    TEST_ASSERT_EQUAL_INT32(290000, r.in.actual_nm[hal_axis_u]);
}

static void test_index_after_the_stop_is_the_home(void)
{
    begin(1, true);
    cfg.jog.order.home_nm = 100000;
    (void)plan();
    (void)press(press_q6, 1000);
    go_back(10000);
    (void)plan();
    TEST_ASSERT_EQUAL_INT(cam_jog_index, h.phase);
    go_back(123456);
    r.in.inputs |= hal_in_index_u;
    (void)plan();
    TEST_ASSERT_EQUAL_INT(cam_jog_done, h.end);
    TEST_ASSERT_EQUAL_INT32(100000, r.in.actual_nm[hal_axis_u]);
}

/// Only a home lifts the limit of the force: U may still press on its stop.
static void test_force_stays_limited_until_a_home_is_found(void)
{
    begin(1, false);
    (void)plan();
    cfg.jog.order = (cam_jog_order_t){.serial = 2};
    (void)plan();
    TEST_ASSERT_EQUAL_INT(cam_jog_stopped, h.end);
    TEST_ASSERT_EQUAL_INT32(press_q6, m.u_press_q6);
    cfg.jog.order = (cam_jog_order_t){
        .serial = 3, .until = 100000, .begin = cam_jog_search, .axis = hal_axis_u, .sense = 1};
    (void)plan(); // a search for a switch
    TEST_ASSERT_EQUAL_INT(cam_jog_search, h.phase);
    TEST_ASSERT_EQUAL_INT32(press_q6, m.u_press_q6);
    const cam_jog_order_t x_here = {
        .serial = 4, .until = 100000, .begin = cam_jog_here, .axis = hal_axis_x};
    cfg.jog.order = x_here;
    (void)plan();
    TEST_ASSERT_EQUAL_INT32(press_q6, m.u_press_q6);
    cfg.jog.order.serial = 5;
    cfg.jog.order.axis = hal_axis_u;
    (void)plan();
    TEST_ASSERT_EQUAL_INT32(0, m.u_press_q6);
}
