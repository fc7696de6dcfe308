// SPDX-License-Identifier: Apache-2.0
// Limits that are fixed when an image is built: cam_param.c is built into this program with
// hard_limits.h, in front of the one that all others use.
#include "cam_machine.h"
#include "cam_param.h"
#include "fixture_can.h"
#include "hal_host.h"
#include "unity.h"

enum { set = 6, get_minimum = 9, get_maximum };

static fixture_can_t f;

void setUp(void)
{
    const fixture_part_t part = fixture_part_short();
    fixture_can_init(&f, &part, 20000);
    fixture_can_start(&f);
}

static void expect_info(cam_param_id_t id, int32_t min, int32_t def, int32_t max, bool is_hard)
{
    const cam_param_info_t *info = cam_param_info(id);
    TEST_ASSERT_EQUAL_INT32_MESSAGE(min, info->min, info->name);
    TEST_ASSERT_EQUAL_INT32_MESSAGE(def, info->def, info->name);
    TEST_ASSERT_EQUAL_INT32_MESSAGE(max, info->max, info->name);
    TEST_ASSERT_EQUAL_INT_MESSAGE(is_hard, info->is_hard, info->name);
}

static void test_ranges_are_those_that_both_lists_allow(void)
{
    expect_info(cam_param_u_stroke_nm, 1000, 800000, 800000, true);
    expect_info(cam_param_spindle_limit_mrpm, 1000, 2000000, 2000000, true);
    expect_info(cam_param_following_limit_nm, 1000, 50000, 50000, true);
    expect_info(cam_param_x_speed_um_per_s, 100, 100000, 10000000, false);
}

static void test_defaults_of_a_port_are_led_into_them(void)
{
    hal_host.slow.measures_u = true; // learning is on by default, the following limit derived
    fixture_can_start(&f);
    TEST_ASSERT_EQUAL_INT32(4, f.rig.machine.params.learn_harmonics);
    TEST_ASSERT_EQUAL_INT32(1000, f.rig.machine.params.following_limit_nm);
}

static void test_no_value_beyond_is_taken_and_the_refusal_brings_the_range(void)
{
    const fixture_answer_t refused = fixture_can_command(&f, set, cam_param_u_stroke_nm, 800001);
    TEST_ASSERT_EQUAL_INT32(cam_err_hard_limit, refused.result);
    TEST_ASSERT_EQUAL_INT32(800000, refused.value);
    const hal_can_frame_t last = fixture_can_sent(0x5C0);
    const fixture_answer_t answer = fixture_can_answer(&last);
    TEST_ASSERT_EQUAL_UINT32(get_maximum, answer.command);
    TEST_ASSERT_EQUAL_INT32(800000, answer.value);
    cam_params_t *params = &f.rig.machine.params;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_param_set(params, cam_param_u_stroke_nm, 799999));
    TEST_ASSERT_EQUAL_INT(cam_err_param_range,
                          cam_param_set(params, cam_param_x_speed_um_per_s, 99));
}

static void test_kept_parameters_beyond_them_are_left_at_their_defaults(void)
{
    cam_machine_t *m = &f.rig.machine;
    m->params.u_stroke_nm = 1200000; // as an image without the limits has kept it
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_save_params(m));
    fixture_can_start(&f);
    TEST_ASSERT_EQUAL_INT32(800000, m->params.u_stroke_nm);
    TEST_ASSERT_EQUAL_UINT32(1, m->kept.n_unfit);
}
