// SPDX-License-Identifier: Apache-2.0
// Overrides, trim, hold and the number of parts over CAN: what is answered, and what is done.
#include "can_bench.h"
#include "expect_can.h"
#include "unity.h"

enum { hold = 40, resume, set_feed_override, set_spindle_override, set_trim, set_parts, get_parts };

static void until(cam_state_t state)
{
    expect_state_within(&f, state, 20000);
}

/// Overrides and trim are parameters, and the answer names which.
static void test_each_change_sets_its_parameter(void)
{
    expect_answer(&f, cam_ok, 750000, set_feed_override, cam_param_feed_override_ppm, 750000);
    expect_answer(&f, cam_ok, 900000, set_spindle_override, cam_param_spindle_override_ppm, 900000);
    expect_answer(&f, cam_ok, -12345, set_trim, cam_param_x_trim_nm, -12345);
    TEST_ASSERT_EQUAL_INT32(750000, f.rig.machine.params.feed_override_ppm);
    TEST_ASSERT_EQUAL_INT32(900000, f.rig.machine.params.spindle_override_ppm);
    TEST_ASSERT_EQUAL_INT32(-12345, f.rig.machine.params.x_trim_nm);
}

static void test_a_change_out_of_range_changes_nothing(void)
{
    TEST_ASSERT_EQUAL_INT32(cam_err_param_range,
                            fixture_can_command(&f, set_spindle_override, 0, 1300000).result);
    TEST_ASSERT_EQUAL_INT32(1000000, f.rig.machine.params.spindle_override_ppm);
}

static void test_parts_are_set_and_told(void)
{
    expect_answer(&f, cam_ok, 0, get_parts, 3, 0);
    expect_answer(&f, cam_ok, 4711, set_parts, 5, 4711);
    expect_answer(&f, cam_ok, 4711, get_parts, 3, 0);
    f.rig.machine.n_parts = UINT32_MAX;
    expect_answer(&f, cam_ok, INT32_MAX, get_parts, 0, 0);
}

static void test_hold_and_resume_are_carried_out(void)
{
    expect_answer(&f, cam_err_state, 0, hold, 7, 0);
    expect_answer(&f, cam_err_state, 0, resume, 8, 0);
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_cutting));
    expect_answer(&f, cam_ok, 0, hold, 9, 0);
    until(cam_state_holding);
    expect_answer(&f, cam_ok, 0, resume, 10, 0);
    until(cam_state_cutting);
}
