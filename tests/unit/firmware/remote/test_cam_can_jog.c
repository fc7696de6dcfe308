// SPDX-License-Identifier: Apache-2.0
// Commands by hand over CAN, and the pages that tell how they go.
#include "can_bench.h"
#include "hal_host.h"
#include "unity.h"

enum { manual = 30, jog, step, home_axis, zero_x, zero_z, set_tool, get_place };
enum { page_homes = 16, page_hand = 17, x_axis = 1, z_axis = 2 };

static fixture_answer_t done(uint8_t command, uint8_t axis, int32_t value)
{
    const fixture_answer_t answer = fixture_can_command(&f, command, axis, value);
    TEST_ASSERT_EQUAL_UINT32(command, answer.command);
    TEST_ASSERT_EQUAL_INT32(cam_ok, answer.result);
    fixture_can_loop(&f, 20);
    return answer;
}

/// @return the newest page, after all pages were sent
static hal_can_frame_t page(uint8_t number)
{
    hal_can_frame_t frame = {0};
    for (int i = 0; i < 40 && frame.id == 0u; i++) {
        fixture_can_loop(&f, 200);
        frame = fixture_can_detail(number);
    }
    TEST_ASSERT_NOT_EQUAL_UINT32(0, frame.id);
    return frame;
}

static void test_jog_and_step_move_and_the_pages_tell(void)
{
    (void)done(manual, 0, 0);
    TEST_ASSERT_EQUAL_INT(cam_state_manual, fixture_rig_state());
    (void)done(jog, x_axis, 5000);
    (void)done(jog, x_axis, 0);
    fixture_can_loop(&f, 2000);
    const int32_t x_nm = done(get_place, x_axis, 0).value;
    TEST_ASSERT_EQUAL_INT32(hal_host.out.axis[hal_axis_x].pos_nm, x_nm);
    TEST_ASSERT_GREATER_THAN_INT32(100, x_nm);
    (void)done(step, z_axis, -1000);
    fixture_can_loop(&f, 2000);
    TEST_ASSERT_EQUAL_INT32(-1000, done(get_place, z_axis, 0).value);
    const hal_can_frame_t hand = page(page_hand);
    TEST_ASSERT_EQUAL_UINT8(cam_jog_rest, hand.data[1]);
    TEST_ASSERT_EQUAL_UINT8(cam_jog_done, hand.data[2]);
    TEST_ASSERT_EQUAL_UINT8(hal_axis_z, hand.data[3]);
    const hal_can_frame_t homes = page(page_homes);
    TEST_ASSERT_EQUAL_INT32(3, fixture_can_i16(&homes, 2)); // orders
    TEST_ASSERT_EQUAL_INT32(x_nm, fixture_can_i32(&homes, 4));
}

static void test_home_zero_and_tool_change_what_the_pages_tell(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&f.rig, cam_param_x_home, 1));
    (void)done(manual, 0, 0);
    (void)done(home_axis, x_axis, 0);
    TEST_ASSERT_EQUAL_INT32(40006000, done(zero_x, 0, 80012000).value);
    TEST_ASSERT_EQUAL_INT32(-5, done(zero_z, 0, -5).value);
    TEST_ASSERT_EQUAL_INT32(3, done(set_tool, 0, 3).value);
    const hal_can_frame_t homes = page(page_homes);
    TEST_ASSERT_EQUAL_UINT8(1u << hal_axis_x, homes.data[1]);
    TEST_ASSERT_EQUAL_INT32(40006000, fixture_can_i32(&homes, 4));
    TEST_ASSERT_EQUAL_UINT8(3, page(page_hand).data[4]);
}

static void test_wrong_axes_and_values_are_refused_with_the_limit(void)
{
    TEST_ASSERT_EQUAL_INT32(cam_err_state, fixture_can_command(&f, jog, x_axis, 1).result);
    (void)done(manual, 0, 0);
    TEST_ASSERT_EQUAL_INT32(cam_err_hand_axis, fixture_can_command(&f, jog, 3, 1).result);
    TEST_ASSERT_EQUAL_INT32(cam_err_hand_axis, fixture_can_command(&f, get_place, 200, 0).result);
    const fixture_answer_t fast = fixture_can_command(&f, jog, x_axis, INT32_MIN);
    TEST_ASSERT_EQUAL_INT32(cam_err_hand_speed, fast.result);
    TEST_ASSERT_EQUAL_INT32(10000, fast.value);
    TEST_ASSERT_EQUAL_INT32(cam_err_param_range, fixture_can_command(&f, set_tool, 0, 5).result);
    fixture_can_loop(&f, 100);
    TEST_ASSERT_EQUAL_INT(cam_state_manual, fixture_rig_state());
}

/// Homes of U and Z are told, too, each by a bit of its own.
static void test_each_home_is_told(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&f.rig, cam_param_u_home, 1));
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&f.rig, cam_param_z_home, 1));
    (void)done(manual, 0, 0);
    (void)done(home_axis, z_axis, 0);
    (void)done(home_axis, 0, 0);
    TEST_ASSERT_EQUAL_UINT8(1u << hal_axis_z | 1u << hal_axis_u, page(page_homes).data[1]);
}
