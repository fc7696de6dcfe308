// SPDX-License-Identifier: Apache-2.0
// Single orders by hand, plan by plan: their target, the origin of U, which only homing of U
// shifts, and homing of a U that takes forces by its stop.
#include "cam_plan.h"
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
                                      .until = 100000,
                                      .sense = 1,
                                      .speed_q10 = 4096,
                                      .slow_q10 = 512,
                                      .low_q10 = -mm * INT64_C(1024),
                                      .high_q10 = mm * INT64_C(1024),
                                      .distance_q10 = 2000 * 1024};
}

/// A plan; the next reading of U counts from its new origin.
/// @return [nm] by which the plan shifts the origin of U
static int32_t jog(void)
{
    const int32_t before_nm = m.u.home_nm;
    cam_jog_isr(&h, &cfg, &r, &m);
    const int32_t shift_nm = m.u.home_nm - before_nm;
    r.in.actual_nm[hal_axis_u] += shift_nm;
    return shift_nm;
}

static int32_t order(cam_jog_phase_t begin, hal_axis_t axis)
{
    cfg.jog.order.serial++;
    cfg.jog.order.begin = begin;
    cfg.jog.order.axis = axis;
    return jog();
}

/// No order of X or Z, and none but homing of U, shifts the origin of U; nor does a plan without.
static void test_origin_of_u_shifts_by_its_homing_alone(void)
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
                TEST_ASSERT_EQUAL_INT32(0, jog());
            }
        }
    }
}

/// An order holds before its tick, not in it; one that is too old finds no home.
static void test_order_holds_to_the_tick_before_its_last(void)
{
    for (uint32_t until = 4999; until <= 5002u; until++) {
        setUp();
        r.tick = 5000;
        cfg.jog.order.until = until;
        TEST_ASSERT_EQUAL_INT32(0, order(cam_jog_jog, hal_axis_x));
        TEST_ASSERT_EQUAL_UINT32(cfg.jog.order.serial, h.serial);
        TEST_ASSERT_EQUAL(until <= 5000u, h.end == cam_jog_silent);
        (void)order(cam_jog_here, hal_axis_u);
        TEST_ASSERT_EQUAL(until > 5000u, h.homed != 0u);
    }
}

/// The place of U becomes that of its home, exactly; one nanometre beyond its stroke is refused.
static void test_home_here_is_the_number_that_was_ordered(void)
{
    r.in.actual_nm[hal_axis_u] = 7000;
    m.axis[hal_axis_u].pos_q10 = 7000 * 1024;
    cfg.jog.order.home_nm = 6999;
    m.u_target_q10 = 8000 * 1024;
    TEST_ASSERT_EQUAL_INT32(-1, order(cam_jog_here, hal_axis_u));
    TEST_ASSERT_EQUAL_INT64(7999 * 1024, m.u_target_q10);
    TEST_ASSERT_EQUAL_HEX32(1u << hal_axis_u, h.homed);
    TEST_ASSERT_EQUAL_INT(cam_jog_done, h.end);
    TEST_ASSERT_EQUAL_INT32(7000, h.found_nm[hal_axis_u]);
    TEST_ASSERT_EQUAL_UINT32(1, h.n_found);
    cfg.jog.order.home_nm = end_nm;
    TEST_ASSERT_EQUAL_INT32(end_nm - 6999, order(cam_jog_here, hal_axis_u));
    cfg.jog.order.home_nm = end_nm + 1;
    TEST_ASSERT_EQUAL_INT32(0, order(cam_jog_here, hal_axis_u));
    TEST_ASSERT_EQUAL_INT(cam_jog_no_stroke, h.end);
    TEST_ASSERT_EQUAL_UINT32(2, h.n_found);
    m.axis[hal_axis_u].pos_q10 = (int64_t)(end_nm + 1) * 1024; // it need not move its numbers
    cfg.jog.order.home_nm = r.in.actual_nm[hal_axis_u];
    TEST_ASSERT_EQUAL_INT32(0, order(cam_jog_here, hal_axis_u));
    TEST_ASSERT_EQUAL_INT(cam_jog_done, h.end);
    TEST_ASSERT_EQUAL_UINT32(3, h.n_found);
}

/// Its command shifts with the origin, within the words of the guard and of its set-point.
static void test_command_of_u_shifts_with_its_origin(void)
{
    static const struct {
        int32_t nm, shift_nm, to_nm;
    } rows[] = {{30 * mm, 7, 30 * mm + 7},
                {-30 * mm, -7, -30 * mm - 7},
                {(1 << 25) - 3, 7, (1 << 25) - 1},
                {3 - (1 << 25), -7, -(1 << 25)}};
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        setUp();
        m.u.nm = rows[i].nm;
        m.u.set_q6 = rows[i].nm * 64;
        cfg.jog.order.home_nm = rows[i].shift_nm;
        TEST_ASSERT_EQUAL_INT32(rows[i].shift_nm, order(cam_jog_here, hal_axis_u));
        TEST_ASSERT_EQUAL_INT32(rows[i].to_nm, m.u.nm);
        TEST_ASSERT_INT32_WITHIN(63, rows[i].to_nm * 64, m.u.set_q6);
    }
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

/// The switch is left only by moving back from it.
static void test_home_switch_that_bounces_is_not_left_yet(void)
{
    for (int32_t sense = -1; sense <= 1; sense += 2) {
        setUp();
        cfg.jog.order.sense = sense;
        r.in.inputs |= (uint32_t)hal_in_home_u << hal_axis_x;
        (void)order(cam_jog_search, hal_axis_x);
        r.in.inputs = hal_in_drive_ready;
        for (int32_t vel_q10 = 1; vel_q10 >= -1; vel_q10--) {
            TEST_ASSERT_EQUAL_INT(cam_jog_release, h.phase);
            m.axis[hal_axis_x].vel_q10 = sense * vel_q10;
            (void)jog();
        }
        TEST_ASSERT_EQUAL_INT(cam_jog_done, h.end);
    }
}

/// A search forgets the home of its axis, and only that.
static void test_search_forgets_the_home_of_its_axis(void)
{
    h.homed = 7;
    TEST_ASSERT_EQUAL_INT32(0, order(cam_jog_search, hal_axis_x));
    TEST_ASSERT_EQUAL_HEX32(7u & ~(1u << hal_axis_x), h.homed);
    r.in.inputs = 0; // drives without power may come back anywhere
    (void)jog();
    TEST_ASSERT_EQUAL_HEX32(0, h.homed);
}

/// U that ran away has moved while nothing measured it.
static void test_u_loses_its_home_with_its_scale(void)
{
    h.homed = 7;
    r.want.faults = CAM_FAULT_BIT(u_travel);
    cam_jog_idle_isr(&h, &cfg, &r);
    TEST_ASSERT_EQUAL_HEX32(7, h.homed);
    r.want.faults = CAM_FAULT_BIT(u_runaway);
    cam_jog_idle_isr(&h, &cfg, &r);
    TEST_ASSERT_EQUAL_HEX32(7u & ~(1u << hal_axis_u), h.homed);
}

/// A stop ends the order, and the state when all axes rest; it is carried out once, so that what is
/// begun next is not stopped by it.
static void test_stop_ends_order_and_state_once(void)
{
    m.is_clear = true; // by hand the tool may go anywhere
    (void)order(cam_jog_jog, hal_axis_x);
    TEST_ASSERT_FALSE(m.is_clear);
    m.is_stopping = true;
    for (int i = 0; i < 1000 && m.state != cam_state_off; i++) {
        TEST_ASSERT_TRUE(m.is_stopping);
        TEST_ASSERT_EQUAL_INT32(0, jog());
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
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        setUp(); // braking by steps may have led it past the end by as much
        cfg.jog.order.sense = sign;
        m.axis[hal_axis_x].pos_q10 = sign * (mm * INT64_C(1024) + 64);
        (void)order(cam_jog_jog, hal_axis_x);
        TEST_ASSERT_EQUAL_INT64(sign * mm * INT64_C(1024), h.target_q10);
    }
    cfg.jog.order.speed_q10 = 1; // of which a tick has no share
    (void)order(cam_jog_jog, hal_axis_u);
    TEST_ASSERT_EQUAL_INT32(1, m.u_speed_q10);
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

/// A U that the port counts beyond the words of its set-points is refused for its search and its
/// home here.
static void test_home_of_u_from_far_away_is_refused(void)
{
    static const cam_jog_phase_t begins[] = {cam_jog_search, cam_jog_here};
    for (int i = 0; i < 4; i++) {
        const int32_t far_nm = i % 2 == 0 ? 35 * mm : -35 * mm;
        setUp();
        r.in.actual_nm[hal_axis_u] = far_nm;
        m.axis[hal_axis_u].pos_q10 = far_nm * INT64_C(1024);
        TEST_ASSERT_EQUAL_INT32(0, order(begins[i / 2], hal_axis_u));
        TEST_ASSERT_EQUAL_INT(cam_jog_no_stroke, h.end);
        TEST_ASSERT_EQUAL_HEX32(0, h.homed);
    }
}

enum { press_q6 = 64000, still_plans = 50 };

/// Begin a search for the stop. @return [nm] shift of U's origin
static int32_t search(int32_t sense, bool has_index, int32_t home_nm)
{
    setUp();
    cfg.jog.order.sense = sense;
    cfg.jog.order.has_index = has_index;
    cfg.jog.order.distance_q10 = 2 * end_nm * INT64_C(1024);
    cfg.jog.order.home_nm = home_nm;
    cfg.jog.order.press_q6 = press_q6;
    cfg.jog.order.still_plans = still_plans;
    return order(cam_jog_search, hal_axis_u);
}

/// U presses and stands. @return plans in which the phase was still the search
static int press(int32_t force_q6, int n)
{
    int k = 0;
    r.force_q6 = cfg.jog.order.sense * force_q6;
    while (k < n && h.phase == cam_jog_search) {
        (void)jog();
        k++;
    }
    return k;
}

/// A plan with U and its set-point moved back by a distance.
static void go_back(int32_t by_nm)
{
    const int32_t sense = cfg.jog.order.sense;
    r.in.actual_nm[hal_axis_u] -= sense * by_nm;
    m.axis[hal_axis_u].pos_q10 = (int64_t)r.in.actual_nm[hal_axis_u] * 1024;
    m.axis[hal_axis_u].vel_q10 = -sense * 512;
    r.force_q6 = 0;
    (void)jog();
}

static void test_stop_is_found_when_u_stands_under_its_largest_force(void)
{
    for (int side = -1; side <= 1; side += 2) {
        TEST_ASSERT_EQUAL_INT32(-side * end_nm, search(side, false, side * 550000));
        TEST_ASSERT_EQUAL_INT32(press_q6, m.u_press_q6);
        TEST_ASSERT_EQUAL_INT(1000, press(press_q6 - 1, 1000));
        TEST_ASSERT_EQUAL_INT(1000, press(-press_q6, 1000));
        TEST_ASSERT_INT_WITHIN(1, still_plans, press(press_q6, 1000));
        TEST_ASSERT_EQUAL_INT(cam_jog_release, h.phase);
        TEST_ASSERT_EQUAL_HEX32(0, h.homed);
    }
    (void)search(1, false, 550000); // one that moves or presses less is not at its stop yet
    TEST_ASSERT_EQUAL_INT(still_plans - 1, press(press_q6, still_plans - 1));
    r.in.actual_nm[hal_axis_u] += 1000; // still stands
    TEST_ASSERT_LESS_OR_EQUAL_INT(2, press(press_q6, 1000));
    TEST_ASSERT_EQUAL_INT(cam_jog_release, h.phase);
    (void)search(1, false, 550000);
    TEST_ASSERT_EQUAL_INT(still_plans - 1, press(press_q6, still_plans - 1));
    r.in.actual_nm[hal_axis_u] += 1001;
    TEST_ASSERT_EQUAL_INT(still_plans - 1, press(press_q6, still_plans - 1));
    TEST_ASSERT_EQUAL_INT(1, press(press_q6 - 1, 1));
    TEST_ASSERT_INT_WITHIN(1, still_plans, press(press_q6, 1000));
    TEST_ASSERT_EQUAL_INT(cam_jog_release, h.phase);
}

/// U has a home where it stood, as soon as it is within its stroke and ten micrometres back.
static void test_home_is_the_stop_and_counts_within_the_stroke(void)
{
    static const struct {
        int32_t sense, home_nm, before_nm, last_nm;
    } rows[] = {{-1, -550000, 49000, 2000}, {1, 550000, 49000, 2000}, {1, 300000, 9999, 1}};
    for (int i = 0; i < 3; i++) {
        (void)search(rows[i].sense, false, rows[i].home_nm);
        (void)press(press_q6, 1000);
        go_back(rows[i].before_nm);
        TEST_ASSERT_EQUAL_INT(cam_jog_release, h.phase);
        TEST_ASSERT_EQUAL_INT32(press_q6, m.u_press_q6);
        go_back(rows[i].last_nm);
        TEST_ASSERT_EQUAL_INT(cam_jog_done, h.end);
        const int32_t back_nm = rows[i].before_nm + rows[i].last_nm;
        TEST_ASSERT_EQUAL_INT32(rows[i].home_nm - rows[i].sense * back_nm,
                                r.in.actual_nm[hal_axis_u]);
        TEST_ASSERT_EQUAL_INT32(0, m.u_press_q6);
    }
}

/// Within 10 um of its set-point: a scale that freezes on the way back gives no home.
static void test_u_must_follow_from_its_stop(void)
{
    for (int32_t off_nm = 10000; off_nm <= 10001; off_nm++) {
        (void)search(1, false, 550000);
        (void)press(press_q6, 1000);
        go_back(49000);
        r.in.actual_nm[hal_axis_u] += off_nm;
        go_back(2000);
        m.axis[hal_axis_u].pos_q10 -= (int64_t)off_nm * 1024;
        (void)jog();
        TEST_ASSERT_EQUAL_INT(off_nm == 10000 ? cam_jog_done : cam_jog_runs, h.end);
    }
}

static void test_index_after_the_stop_is_the_home(void)
{
    (void)search(1, true, 100000);
    (void)press(press_q6, 1000);
    go_back(10000);
    TEST_ASSERT_EQUAL_INT(cam_jog_index, h.phase);
    r.in.inputs |= hal_in_index_u;
    go_back(123456);
    TEST_ASSERT_EQUAL_INT(cam_jog_done, h.end);
    TEST_ASSERT_EQUAL_INT32(100000, r.in.actual_nm[hal_axis_u]);
}

/// Readings and positions at the ends of their words: two metres back, and far out of the stroke.
static void test_distance_from_the_stop_has_no_limit(void)
{
    for (int has_index = 0; has_index <= 1; has_index++) {
        (void)search(-1, has_index != 0, 0);
        (void)press(press_q6, 1000);
        h.stood_nm = has_index != 0 ? 1 << 30 : 0;
        r.in.actual_nm[hal_axis_u] = -(1 << 30);
        m.axis[hal_axis_u].pos_q10 = has_index != 0 ? -(INT64_C(1) << 40) : INT64_MIN;
        m.axis[hal_axis_u].vel_q10 = 512;
        (void)jog();
        TEST_ASSERT_EQUAL_INT(has_index != 0 ? cam_jog_index : cam_jog_release, h.phase);
    }
}

/// Only a home of U lifts the limit of the force: U may still press on its stop.
static void test_force_stays_limited_until_a_home_is_found(void)
{
    static const struct {
        cam_jog_phase_t begin;
        hal_axis_t axis;
        int32_t press_q6;
    } rows[] = {{cam_jog_rest, hal_axis_u, press_q6},
                {cam_jog_search, hal_axis_u, press_q6}, // for a switch
                {cam_jog_here, hal_axis_x, press_q6},
                {cam_jog_here, hal_axis_u, 0}};
    (void)search(1, false, 0);
    for (uint32_t i = 0; i < 4u; i++) {
        cfg.jog.order.press_q6 = 0;
        (void)order(rows[i].begin, rows[i].axis);
        TEST_ASSERT_TRUE(i > 0u || h.end == cam_jog_stopped);
        TEST_ASSERT_TRUE(i != 1u || h.phase == cam_jog_search);
        TEST_ASSERT_EQUAL_INT32(rows[i].press_q6, m.u_press_q6);
    }
}
