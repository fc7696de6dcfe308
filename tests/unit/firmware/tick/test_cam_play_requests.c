// SPDX-License-Identifier: Apache-2.0
// What the interrupt makes of requests while the axes follow the table, and of inputs while it is
// off.
#include "play_bench.h"

/// In the cut the background check of the table raises its fault in the tick that sees the request,
/// once.
static void test_fault_of_the_background_check_is_raised_in_the_cut(void)
{
    static const cam_state_t states[] = {cam_state_engaging, cam_state_cutting};
    for (int i = 0; i < 2; i++) {
        setUp();
        TEST_ASSERT_TRUE(fixture_play_bring(&f, states[i]));
        if (i == 0) {
            TEST_ASSERT_TRUE(fixture_play_approach(&f));
        }
        TEST_ASSERT_EQUAL_HEX32(0, f.want.faults);
        fixture_play_do(&f, cam_request_table_fault);
        TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(table), f.want.faults);
        fixture_play_tick(&f);
        TEST_ASSERT_EQUAL_HEX32(0, f.want.faults);
    }
}

/// Any other request but stop does not fit the cut, and changes nothing of it.
static void test_requests_that_do_not_fit_the_cut_are_nothing(void)
{
    static const cam_request_t requests[] = {
        cam_request_none,  cam_request_enable,   cam_request_disable, cam_request_start,
        cam_request_reset, cam_request_identify, cam_request_manual};
    TEST_ASSERT_TRUE(fixture_play_bring(&f, cam_state_cutting));
    const int64_t end_q32 = f.plan.disengage_at_q32;
    for (uint32_t i = 0; i < sizeof requests / sizeof requests[0]; i++) {
        fixture_play_do(&f, requests[i]);
        TEST_ASSERT_EQUAL_HEX32(0, f.want.faults);
        TEST_ASSERT_FALSE(f.motion.is_stopping);
        fixture_play_ticks(&f, 2 * FIXTURE_PLAN_TICKS);
        TEST_ASSERT_EQUAL_INT(cam_state_cutting, f.want.state);
        TEST_ASSERT_EQUAL_INT64(end_q32, f.plan.disengage_at_q32);
        TEST_ASSERT_EQUAL_UINT32(f.n_asked, f.play.request);
    }
}

/// A chain that was open for a single tick between two plans is remembered until a plan has seen
/// it.
static void test_an_emergency_stop_between_two_plans_is_remembered(void)
{
    fixture_play_ticks(&f, 3);
    TEST_ASSERT_FALSE(f.motion.was_open);
    TEST_ASSERT_TRUE(f.motion.was_off);
    f.in.inputs |= (uint32_t)hal_in_estop;
    fixture_play_tick(&f);
    TEST_ASSERT_TRUE(f.motion.was_open);
    f.in.inputs &= ~(uint32_t)hal_in_estop;
    fixture_play_tick(&f);
    TEST_ASSERT_TRUE(f.motion.was_open);
    f.motion.was_open = false; // a plan has seen it
    fixture_play_tick(&f);
    TEST_ASSERT_FALSE(f.motion.was_open);
}

/// Without enable set-points are where the axes are, to the ends of what is sensed.
static void test_off_follows_the_axes_as_far_as_they_go(void)
{
    f.is_axes_held = true;
    for (uint32_t axis = 0; axis < hal_n_axes; axis++) {
        f.in.actual_nm[axis] = axis == 1u ? cam_sense_most_nm - 1 : -1000 * (int32_t)axis;
    }
    fixture_play_tick(&f);
    for (uint32_t axis = 0; axis < hal_n_axes; axis++) {
        const int64_t nm = axis == 1u ? cam_sense_most_nm - 1 : -1000 * (int64_t)axis;
        TEST_ASSERT_EQUAL_INT64(nm * 1024, f.motion.axis[axis].pos_q10);
        TEST_ASSERT_EQUAL_INT32(0, f.motion.axis[axis].vel_q10);
    }
    f.in.actual_nm[0] = -cam_sense_most_nm;
    fixture_play_tick(&f);
    TEST_ASSERT_EQUAL_INT64(-(int64_t)cam_sense_most_nm * 1024, f.motion.axis[0].pos_q10);
}

/// Whatever an earlier motion by hand has left, the next one begins with axes that stand.
static void test_motion_by_hand_begins_at_rest(void)
{
    fixture_play_ticks(&f, 3);
    f.motion.u_speed_q10 = 12345;
    f.motion.is_stopping = true;
    fixture_play_do(&f, cam_request_manual);
    TEST_ASSERT_EQUAL_INT(cam_state_manual, f.motion.state);
    TEST_ASSERT_EQUAL_INT32(0, f.motion.u_speed_q10);
    TEST_ASSERT_FALSE(f.motion.is_stopping);
    TEST_ASSERT_TRUE(f.motion.is_by_hand);
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
