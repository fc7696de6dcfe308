// SPDX-License-Identifier: Apache-2.0
// What the controller tells people unasked, line by line: its start, changes of state, faults.
#include "can_bench.h"
#include "hal_host.h"
#include "unity.h"

#include <stdio.h>  // snprintf
#include <string.h> // strlen, memset

static void test_a_long_line_is_cut_off(void)
{
    static char why[300];
    memset(why, 'w', sizeof why - 1u);
    hal_host.slow.start = (hal_start_t){.reset = hal_reset_halt, .why = why};
    fixture_can_start(&f);
    TEST_ASSERT_EQUAL_size_t(120, strlen(fixture_can_line(2)));
    TEST_ASSERT_EQUAL_STRING_LEN("start: halt: wwww", fixture_can_line(2), 17);
}

static void test_every_change_of_state_is_told_once(void)
{
    TEST_ASSERT_EQUAL_UINT32(3, hal_host.n_lines); // start, params, table
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_homing));
    fixture_can_loop(&f, 10);
    TEST_ASSERT_EQUAL_UINT32(4, hal_host.n_lines);
    TEST_ASSERT_EQUAL_STRING("state homing", fixture_can_line(0));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_disable(&f.rig.machine));
    fixture_can_loop(&f, 10);
    TEST_ASSERT_EQUAL_UINT32(5, hal_host.n_lines);
    TEST_ASSERT_EQUAL_STRING("state off", fixture_can_line(0));
}

static void test_every_fault_is_told_once_and_again_after_a_reset(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&f.rig, cam_param_lead_ns, 50000));
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_cutting));
    fixture_can_loop(&f, 1);
    const uint32_t n_lines = hal_host.n_lines;
    f.rig.lathe.error_nm[hal_axis_u] = 200000;
    hal_host_fault_estop(true);
    fixture_can_loop(&f, 4000);
    TEST_ASSERT_EQUAL_UINT32(n_lines + 3u, hal_host.n_lines); // one a poll, lowest bit first
    TEST_ASSERT_EQUAL_STRING("state fault", fixture_can_line(2));
    TEST_ASSERT_EQUAL_STRING("fault estop: emergency stop", fixture_can_line(1));
    TEST_ASSERT_EQUAL_STRING("fault following_error: U does not follow", fixture_can_line(0));
    hal_host_fault_drive(true); // a second fault beside the first
    fixture_can_loop(&f, 2);
    TEST_ASSERT_EQUAL_STRING("fault drive: a drive is not ready", fixture_can_line(0));
    hal_host_fault_drive(false);
    hal_host_fault_estop(false);
    f.rig.lathe.error_nm[hal_axis_u] = 0;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_reset(&f.rig.machine));
    fixture_can_loop(&f, 3);
    TEST_ASSERT_EQUAL_STRING("state off", fixture_can_line(0));
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_homing));
    hal_host_fault_estop(true);
    fixture_can_loop(&f, 3);
    TEST_ASSERT_EQUAL_STRING("fault estop: emergency stop", fixture_can_line(0));
}

/// What a check of a table may refuse: its image and its signature.
static void test_every_text_fits_a_line(void)
{
    for (int err = 0; err > -140; err--) {
        if (err < -19 && err > -130) {
            continue;
        }
        char line[200];
        (void)snprintf(line, sizeof line, "table: %s - home refused until a table is written",
                       cam_err_text((cam_err_t)err));
        TEST_ASSERT_LESS_OR_EQUAL_size_t(120, strlen(line));
    }
}
