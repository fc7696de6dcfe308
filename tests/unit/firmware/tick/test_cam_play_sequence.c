// SPDX-License-Identifier: Apache-2.0
// States and requests: what is carried out when, and that no course of a cut makes an axis jump.
#include "cam_fix.h"
#include "play_bench.h"
#include <math.h>

static double step_nm(hal_axis_t axis)
{
    return (double)(f.axis[axis].pos_q10 - f.before[axis].pos_q10) / 1024.0;
}

/// Limits of the defaults at 20 kHz [nm per tick, per tick^2]; U as the table of the short part.
static void expect_smooth_until(cam_state_t state)
{
    static const double speed[hal_n_axes] = {5001.0, 1251.0, 2501.0};
    static const double acceleration[hal_n_axes] = {
        170.0, 12.0, 5.2}; // increments change once per plan, and with them the height of U
    double before[hal_n_axes];
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        before[i] = step_nm((hal_axis_t)i);
    }
    for (uint32_t n = 0; n < 100000u && f.want.state != state; n++) {
        fixture_play_tick(&f);
        for (uint32_t i = 0; i < hal_n_axes; i++) {
            const double nm = step_nm((hal_axis_t)i);
            TEST_ASSERT_TRUE(fabs(nm) <= speed[i]);
            TEST_ASSERT_DOUBLE_WITHIN(acceleration[i], before[i], nm);
            before[i] = nm;
        }
    }
    TEST_ASSERT_EQUAL_INT(state, f.want.state);
}

/// Tick until the spindle is that far behind the start of the feed.
static void turn_to(double turns)
{
    const int64_t goal_q32 = f.plan.feed_at_q32 + llround(turns * 4294967296.0);
    while (f.angle.pos_q32 < goal_q32) {
        fixture_play_tick(&f);
    }
}

static void test_homing_needs_index_and_rotation_in_the_sense_of_cutting(void)
{
    static const struct {
        bool is_synced;
        int32_t speed_q32;
        cam_state_t state;
    } cases[] = {{false, 8947849, cam_state_homing},  {true, 0, cam_state_homing},
                 {true, -8947849, cam_state_homing},  {true, 17895, cam_state_homing},
                 {false, -8947849, cam_state_homing}, {true, 17896, cam_state_ready}};
    bring(cam_state_homing);
    for (int i = 0; i < 6; i++) {
        f.angle.is_synced = cases[i].is_synced;
        f.angle.speed_q32 = cases[i].speed_q32; // 5 r/min is 17 895.7
        fixture_play_ticks(&f, 5000);           // U has retracted meanwhile
        TEST_ASSERT_EQUAL_INT(cases[i].state, f.want.state);
        TEST_ASSERT_EQUAL_INT32(2500000, f.want.spindle_mrpm);
    }
    TEST_ASSERT_EQUAL_INT64(-500000 * 1024, f.axis[hal_axis_u].pos_q10);
}

/// Every request in every state: which state follows in the very next tick. Only a stop changes the
/// end of a cut, and the background check of the table raises its fault in the same tick.
static void test_requests_out_of_order_are_ignored(void)
{
    enum { o = cam_state_off, h, r, e, c, d, m = cam_state_manual };
    static const int next[6][9] = {
        // none, enable, disable, start, stop, reset, table fault, identify, manual
        {o, h, o, o, o, o, o, o, m}, {h, h, o, h, h, h, h, h, h}, {r, r, o, e, r, r, r, r, r},
        {e, e, e, e, e, e, e, e, e}, {c, c, c, c, c, c, c, c, c}, {d, d, d, d, d, d, d, d, d},
    };
    for (int state = o; state <= d; state++) {
        for (int request = cam_request_none; request <= cam_request_manual; request++) {
            setUp();
            bring((cam_state_t)state);
            TEST_ASSERT_TRUE(state != e || fixture_play_approach(&f));
            const bool is_cut = state == e || state == c;
            const int64_t end_q32 = f.plan.disengage_at_q32;
            fixture_play_do(&f, (cam_request_t)request);
            TEST_ASSERT_EQUAL_STRING(cam_state_name((cam_state_t)next[state][request]),
                                     cam_state_name(f.want.state));
            TEST_ASSERT_EQUAL_UINT32(f.n_asked, f.play.request);
            const bool is_table = request == cam_request_table_fault;
            TEST_ASSERT_EQUAL_HEX32(is_table && state != o ? CAM_FAULT_BIT(table) : 0u,
                                    f.want.faults);
            fixture_play_ticks(&f, is_cut || state == d ? 2 * FIXTURE_PLAN_TICKS : 0);
            TEST_ASSERT_EQUAL(is_cut && request == cam_request_stop,
                              end_q32 != f.plan.disengage_at_q32);
        }
    }
    setUp();
    bring(cam_state_ready);
    f.motion.state = cam_state_identifying; // the wave is over, and its end is ready
    fixture_play_do(&f, cam_request_disable);
    TEST_ASSERT_EQUAL_INT(cam_state_ready, f.want.state);
}

static void test_reset_before_the_retract_has_ended_is_ignored(void)
{
    bring(cam_state_cutting);
    fixture_play_settle(&f, false);
    fixture_play_do(&f, cam_request_reset);
    TEST_ASSERT_EQUAL_INT(cam_state_fault, f.want.state);
    TEST_ASSERT_EQUAL_INT32(0, f.want.spindle_mrpm);
    for (int request = cam_request_none; request <= cam_request_stop; request++) {
        fixture_play_settle(&f, true);
        fixture_play_do(&f, (cam_request_t)request);
        TEST_ASSERT_EQUAL_INT(cam_state_fault, f.want.state);
    }
    fixture_play_settle(&f, true);
    fixture_play_do(&f, cam_request_reset);
    TEST_ASSERT_EQUAL_INT(cam_state_off, f.want.state);
}

/// The amplitude was rising when the fault came: going on, it would leave its word in a second.
static void test_increments_of_the_cut_end_with_a_fault(void)
{
    bring(cam_state_engaging);
    TEST_ASSERT_TRUE(fixture_play_approach(&f));
    fixture_play_ticks(&f, 5 * 480);
    TEST_ASSERT_GREATER_THAN_INT32(0, f.motion.scale_step_q30);
    fixture_play_settle(&f, false);
    fixture_play_ticks(&f, FIXTURE_PLAN_TICKS);
    const cam_motion_t then = f.motion;
    fixture_play_ticks(&f, 20 * 1000);
    TEST_ASSERT_EQUAL_INT32(then.scale_q30, f.motion.scale_q30);
    TEST_ASSERT_EQUAL_INT32(then.phase_q32, f.motion.phase_q32);
    TEST_ASSERT_EQUAL_INT64(then.height_q32, f.motion.height_q32);
}

static void test_engage_begins_at_a_whole_turn_after_all_commanded_angles(void)
{
    static const int32_t ahead_ns[][2] = {{0, 0}, {3000000, 0}, {100000, 40000000}};
    for (int i = 0; i < 3; i++) {
        setUp();
        f.params.lead_ns = ahead_ns[i][0];
        f.params.xz_lag_ns = ahead_ns[i][1];
        f.params.z_margin_nm =
            1000000; // axes without a lag lead the set-point that is expected of them
        fixture_play_configure(&f);
        engage();
        const double most = (ahead_ns[i][0] > ahead_ns[i][1] ? ahead_ns[i][0] : ahead_ns[i][1]);
        const double commanded = (double)f.angle.pos_q32 + most / 50000.0 * f.angle.speed_q32;
        TEST_ASSERT_EQUAL_UINT32(0, cam_angle_of_pos(f.plan.engage_at_q32));
        TEST_ASSERT_TRUE((double)f.plan.engage_at_q32 >= commanded - 1e3);
        // not before the plan after the next one
        const double margin = 2.0 * FIXTURE_PLAN_TICKS * f.angle.speed_q32;
        TEST_ASSERT_TRUE((double)f.plan.engage_at_q32 < commanded + margin + 4294967296.0);
        TEST_ASSERT_EQUAL_INT64(f.plan.engage_at_q32 + 10 * CAM_TURN_Q32, f.plan.feed_at_q32);
        expect_smooth_until(cam_state_cutting);
        TEST_ASSERT_TRUE(f.angle.pos_q32 >= f.plan.feed_at_q32);
        TEST_ASSERT_TRUE(f.angle.pos_q32 <
                         f.plan.feed_at_q32 + FIXTURE_PLAN_TICKS * (int64_t)f.angle.speed_q32);
        expect_smooth_until(cam_state_disengaging);
        expect_smooth_until(cam_state_ready);
        TEST_ASSERT_EQUAL_INT64(f.plan.feed_at_q32 + 12 * CAM_TURN_Q32, f.plan.disengage_at_q32);
    }
}

/// Then another start approaches U's zero, X's clearance and the first height.
static void test_stop_while_approaching_goes_back_to_ready(void)
{
    bring(cam_state_ready);
    fixture_play_do(&f, cam_request_start);
    fixture_play_ticks(&f, 2000);
    TEST_ASSERT_FALSE(f.motion.is_playing);
    fixture_play_do(&f, cam_request_stop);
    TEST_ASSERT_EQUAL_INT(cam_state_ready, f.want.state);
    fixture_play_ticks(&f, 20000);
    TEST_ASSERT_EQUAL_INT32(0, f.axis[hal_axis_x].vel_q10);
    TEST_ASSERT_EQUAL_INT64(-500000 * 1024, f.axis[hal_axis_u].pos_q10);
    fixture_play_do(&f, cam_request_start);
    TEST_ASSERT_FALSE(f.motion.is_playing);
    TEST_ASSERT_TRUE(fixture_play_approach(&f));
    TEST_ASSERT_EQUAL_INT64(0, f.axis[hal_axis_u].pos_q10);
    TEST_ASSERT_EQUAL_INT64(0, f.axis[hal_axis_z].pos_q10);
    TEST_ASSERT_DOUBLE_WITHIN(0.01, fixture_play_x_nm(&f, 0.0) + 1e6,
                              (double)f.axis[hal_axis_x].pos_q10 / 1024.0);
}

/// Stop when `turns` are fed. @return [turn] after the start of the feed where it disengages
static double stop_at(double turns)
{
    setUp();
    f.params.lead_ns = 100000;
    f.params.xz_lag_ns = 1000000;
    fixture_play_configure(&f);
    engage();
    turn_to(turns);
    fixture_play_ask(&f, cam_request_stop);
    expect_smooth_until(cam_state_disengaging);
    const double end = fixture_play_turns(f.plan.disengage_at_q32 - f.plan.feed_at_q32);
    const int64_t z_q10 = f.axis[hal_axis_z].pos_q10;
    fixture_play_tick(&f);
    TEST_ASSERT_EQUAL_INT64(z_q10, f.axis[hal_axis_z].pos_q10); // Z stands
    expect_smooth_until(cam_state_ready);
    TEST_ASSERT_EQUAL_INT64(z_q10, f.axis[hal_axis_z].pos_q10);
    return end;
}

/// Before the feed there is none. One that rises or is steady falls from the next turn on, and one
/// that falls is left alone.
static void test_stop_disengages_at_a_whole_turn(void)
{
    static const struct {
        double at, end; ///< [turn]
        int32_t z_nm;
    } cases[] = {
        {-9.7, -9.0, 0},      {-5.2, -5.0, 0},       {-3.001, -3.0, 0},     {-0.2, 0.0, 0},
        {0.3, 2.0, 50000},    {1.5, 4.0, 200000},    {2.5, 5.0, 300000},    {5.5, 8.0, 600000},
        {5.99, 9.0, 700000}, // axes were commanded into turn 6 before
        {9.5, 12.0, 1000000}, {10.3, 12.0, 1000000}, {11.9, 12.0, 1000000},
    };
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const double end = stop_at(cases[i].at);
        const bool is_ahead = cases[i].at < 0.0 && end == cases[i].end + 1.0; // into the next turn
        TEST_ASSERT_TRUE(end == cases[i].end || is_ahead);
        TEST_ASSERT_EQUAL_INT64((int64_t)cases[i].z_nm * 1024, f.axis[hal_axis_z].pos_q10);
    }
}

static void test_stop_twice_does_not_lengthen_the_feed(void)
{
    engage();
    turn_to(4.5);
    fixture_play_do(&f, cam_request_stop);
    const int64_t end_q32 = f.plan.disengage_at_q32;
    turn_to(5.5);
    fixture_play_do(&f, cam_request_stop);
    TEST_ASSERT_EQUAL_INT64(end_q32, f.plan.disengage_at_q32);
    TEST_ASSERT_EQUAL_INT64(7 * CAM_TURN_Q32, f.plan.feed_motion.end_q32 - f.plan.feed_at_q32);
}

static void test_stop_of_a_measured_cut_disengages_at_the_next_turn(void)
{
    f.params.z_is_measured = 1;
    fixture_play_configure(&f);
    engage();
    turn_to(20.4);
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, f.want.state);
    fixture_play_ask(&f, cam_request_stop);
    expect_smooth_until(cam_state_disengaging);
    TEST_ASSERT_EQUAL_INT64(21 * CAM_TURN_Q32, f.plan.disengage_at_q32 - f.plan.feed_at_q32);
    expect_smooth_until(cam_state_ready);
}

/// Off forgets an earlier motion; whatever one by hand has left, the next one begins at rest.
static void test_motion_by_hand_begins_at_rest(void)
{
    cam_motion_t *m = &f.motion;
    fixture_play_ticks(&f, 3);
    m->spindle_mrpm = 1;
    m->is_by_hand = m->is_filtering = true;
    m->was_off = false;
    fixture_play_tick(&f);
    TEST_ASSERT_EQUAL_INT32(0, m->spindle_mrpm);
    TEST_ASSERT_FALSE(m->is_by_hand || m->is_filtering);
    TEST_ASSERT_TRUE(m->was_off);
    m->u_speed_q10 = 12345;
    m->is_stopping = true;
    fixture_play_do(&f, cam_request_manual);
    TEST_ASSERT_EQUAL_INT(cam_state_manual, m->state);
    TEST_ASSERT_EQUAL_INT32(0, m->u_speed_q10);
    TEST_ASSERT_FALSE(m->is_stopping);
    TEST_ASSERT_TRUE(m->is_by_hand);
}

/// U rests in the tick of enable, when a drive may take its zero from the set-point, and for the
/// dwell; then it retracts at once.
static void test_u_rests_after_enable_while_its_drive_takes_over(void)
{
    static const struct {
        int32_t dwell_ms;
        uint32_t ticks;
    } cases[] = {{0, 1}, {100, FIXTURE_PLAY_HZ / 10 + 1}};
    for (int i = 0; i < 2; i++) {
        setUp();
        f.params.enable_dwell_ms = cases[i].dwell_ms;
        fixture_play_configure(&f);
        TEST_ASSERT_TRUE(fixture_play_bring(&f, cam_state_homing));
        const int64_t rest_q10 = f.motion.axis[hal_axis_u].pos_q10;
        fixture_play_ticks(&f, cases[i].ticks - 1);
        TEST_ASSERT_EQUAL_INT64(rest_q10, f.motion.axis[hal_axis_u].pos_q10);
        fixture_play_ticks(&f, 2);
        TEST_ASSERT_LESS_THAN_INT64(rest_q10, f.motion.axis[hal_axis_u].pos_q10);
    }
}
