// SPDX-License-Identifier: Apache-2.0
// What the interrupt makes of a single order by hand: where it leads, and that only homing of U
// changes U's number.
#include "cam_jog.h"
#include "unity.h"

enum { end_nm = 500000, mm = 1000000 };

static cam_jog_t h;
static cam_motion_t m;
static cam_tick_record_t r;
static cam_play_config_t cfg;

void setUp(void)
{
    const cam_motion_limits_t limits = {.speed_q10 = 4096, .acceleration_q10 = 64};
    h = (cam_jog_t){0};
    m = (cam_motion_t){.state = cam_state_manual};
    r = (cam_tick_record_t){.tick = 50, .in.inputs = hal_in_drive_ready};
    cfg = (cam_play_config_t){
        .plan_ticks = 8,
        .per_plan_q30 = 1 << 27,
        .jog = {.u_end_q10 = end_nm * INT64_C(1024), .limits = {limits, limits, limits}}};
    cfg.jog.order = (cam_jog_order_t){.serial = 1,
                                      .until = 1000,
                                      .sense = 1,
                                      .speed_q10 = 4096,
                                      .slow_q10 = 512,
                                      .low_q10 = -mm * INT64_C(1024),
                                      .high_q10 = mm * INT64_C(1024),
                                      .distance_q10 = 2000 * 1024};
}

static int32_t order(cam_jog_phase_t begin, hal_axis_t axis)
{
    cfg.jog.order.serial++;
    cfg.jog.order.begin = begin;
    cfg.jog.order.axis = axis;
    return cam_jog_isr(&h, &cfg, &r, &m);
}

/// Wherever X and Z stand and whatever is ordered, U is called what it was called before; so is it
/// while nothing is ordered.
static void test_number_of_u_changes_by_its_homing_alone(void)
{
    static const cam_jog_phase_t begins[] = {cam_jog_jog, cam_jog_step, cam_jog_search,
                                             cam_jog_here, cam_jog_rest};
    for (uint32_t i = 0; i < 5u; i++) {
        for (uint32_t axis = 0; axis < hal_n_axes; axis++) {
            setUp();
            r.in.actual_nm[axis] = 7000;
            m.axis[axis].pos_q10 = 7000 * 1024;
            const bool is_homing_u = axis == hal_axis_u && (i == 2u || i == 3u);
            const int32_t shift_nm = order(begins[i], (hal_axis_t)axis);
            TEST_ASSERT_EQUAL(is_homing_u, shift_nm != 0);
            for (int k = 0; k < 20 && !is_homing_u; k++) {
                TEST_ASSERT_EQUAL_INT32(0, cam_jog_isr(&h, &cfg, &r, &m));
            }
        }
    }
    setUp();
    r.tick = 2000; // older than its life
    TEST_ASSERT_EQUAL_INT32(0, order(cam_jog_jog, hal_axis_u));
    TEST_ASSERT_EQUAL_INT(cam_jog_silent, h.end);
}

/// Where U stands becomes the number of its home, exactly, and one nanometre more is refused where
/// that is the end of its stroke.
static void test_home_here_is_the_number_that_was_ordered(void)
{
    r.in.actual_nm[hal_axis_u] = 7000;
    m.axis[hal_axis_u].pos_q10 = 7000 * 1024;
    cfg.jog.order.home_nm = 6999;
    TEST_ASSERT_EQUAL_INT32(-1, order(cam_jog_here, hal_axis_u));
    TEST_ASSERT_EQUAL_HEX32(1u << hal_axis_u, h.homed);
    TEST_ASSERT_EQUAL_INT(cam_jog_done, h.end);
    TEST_ASSERT_EQUAL_INT32(7000, h.found_nm[hal_axis_u]);
    TEST_ASSERT_EQUAL_UINT32(1, h.n_found);
    cfg.jog.order.home_nm = end_nm;
    TEST_ASSERT_EQUAL_INT32(end_nm - 7000, order(cam_jog_here, hal_axis_u));
    cfg.jog.order.home_nm = end_nm + 1;
    TEST_ASSERT_EQUAL_INT32(0, order(cam_jog_here, hal_axis_u));
    TEST_ASSERT_EQUAL_INT(cam_jog_no_stroke, h.end);
    TEST_ASSERT_EQUAL_UINT32(2, h.n_found);
}

/// Its search begins at the end of its stroke that leaves the whole of it before the axis.
static void test_search_of_u_has_the_whole_stroke_before_it(void)
{
    for (int32_t sense = -1; sense <= 1; sense += 2) {
        for (int is_on = 0; is_on < 2; is_on++) {
            setUp();
            cfg.jog.order.sense = sense;
            m.axis[hal_axis_u].pos_q10 = 7000 * 1024;
            r.in.inputs |= is_on != 0 ? (uint32_t)hal_in_home_u : 0u;
            const int32_t from_nm = (is_on != 0 ? sense : -sense) * end_nm;
            TEST_ASSERT_EQUAL_INT32(from_nm - 7000, order(cam_jog_search, hal_axis_u));
            TEST_ASSERT_EQUAL_INT(is_on != 0 ? cam_jog_release : cam_jog_search, h.phase);
            const int64_t to_nm = from_nm + (is_on != 0 ? -sense : sense) * 2000;
            TEST_ASSERT_EQUAL_INT64(to_nm * 1024, h.target_q10);
        }
    }
}

/// A search forgets the home of its axis, and only that.
static void test_search_forgets_the_home_of_its_axis(void)
{
    h.homed = 7;
    TEST_ASSERT_EQUAL_INT32(0, order(cam_jog_search, hal_axis_x));
    TEST_ASSERT_EQUAL_HEX32(7u & ~(1u << hal_axis_x), h.homed);
    r.in.inputs = 0; // drives without power may come back anywhere
    (void)cam_jog_isr(&h, &cfg, &r, &m);
    TEST_ASSERT_EQUAL_HEX32(0, h.homed);
}

/// A stop ends the order, and the state when all axes rest; it is carried out once, so that what is
/// begun next is not stopped by it.
static void test_stop_ends_order_and_state_once(void)
{
    (void)order(cam_jog_jog, hal_axis_x);
    m.is_stopping = true;
    for (int i = 0; i < 1000 && m.state != cam_state_off; i++) {
        TEST_ASSERT_TRUE(m.is_stopping);
        TEST_ASSERT_EQUAL_INT32(0, cam_jog_isr(&h, &cfg, &r, &m));
        TEST_ASSERT_EQUAL_INT(cam_jog_stopped, h.end);
        TEST_ASSERT_EQUAL_INT(cam_jog_rest, h.phase);
    }
    TEST_ASSERT_EQUAL_INT(cam_state_off, m.state);
    TEST_ASSERT_FALSE(m.is_stopping);
    TEST_ASSERT_EQUAL_INT32(0, m.axis[hal_axis_x].vel_q10);
}

/// A jog leads to the end of the travel in its sense, a step by its distance but not beyond an end;
/// from outside of the travel neither leads farther out.
static void test_jog_and_step_end_within_the_travel(void)
{
    static const struct {
        cam_jog_phase_t begin;
        int32_t sense, from_nm, distance_nm, to_nm;
    } cases[] = {
        {cam_jog_jog, 1, 0, 0, mm},
        {cam_jog_jog, -1, 0, 0, -mm},
        {cam_jog_step, 1, 5000, -2000, 3000},
        {cam_jog_step, 1, 999000, 2000, mm},
        {cam_jog_step, 1, -999000, -2000, -mm},
        {cam_jog_jog, 1, 2 * mm, 0, 2 * mm},
        {cam_jog_jog, -1, 2 * mm, 0, -mm},
        {cam_jog_step, 1, 2 * mm, 2000, 2 * mm},
        {cam_jog_step, 1, 2 * mm, -2000, 2 * mm - 2000},
        {cam_jog_jog, -1, -2 * mm, 0, -2 * mm},
    };
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        setUp();
        cfg.jog.order.sense = cases[i].sense;
        cfg.jog.order.distance_q10 = cases[i].distance_nm * INT64_C(1024);
        m.axis[hal_axis_x].pos_q10 = cases[i].from_nm * INT64_C(1024);
        (void)order(cases[i].begin, hal_axis_x);
        TEST_ASSERT_EQUAL_INT64(cases[i].to_nm * INT64_C(1024), h.target_q10);
    }
    setUp(); // braking by steps may have led it past the end by as much
    m.axis[hal_axis_x].pos_q10 = mm * INT64_C(1024) + 64;
    (void)order(cam_jog_jog, hal_axis_x);
    TEST_ASSERT_EQUAL_INT64(mm * INT64_C(1024), h.target_q10);
}

/// A fault or another state stops the order that runs; of one that has ended it changes nothing.
static void test_another_state_stops_the_order_that_runs(void)
{
    (void)order(cam_jog_jog, hal_axis_x);
    TEST_ASSERT_EQUAL_INT(cam_jog_runs, h.end);
    cam_jog_idle_isr(&h, &cfg, &r);
    TEST_ASSERT_EQUAL_INT(cam_jog_stopped, h.end);
    TEST_ASSERT_EQUAL_INT(cam_jog_rest, h.phase);
    (void)order(cam_jog_here, hal_axis_x);
    TEST_ASSERT_EQUAL_INT(cam_jog_done, h.end);
    cam_jog_idle_isr(&h, &cfg, &r);
    TEST_ASSERT_EQUAL_INT(cam_jog_done, h.end);
}
