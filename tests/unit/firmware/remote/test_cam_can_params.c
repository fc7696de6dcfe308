// SPDX-License-Identifier: Apache-2.0
// All parameters over CAN: staged and committed, saved and brought back, numbers of a refusal.
#include "cam_machine.h" // cam_refusal_needed
#include "can_bench.h"
#include "expect_can.h"
#include "hal_host.h" // hal_host
#include "unity.h"

/// Commands of camturn.dbc.
enum {
    set = 6,
    begin = 50,
    stage = 51,
    commit = 52,
    save = 53,
    defaults = 54,
    revert = 55,
    refusal = 56,
};

static void test_staged_parameters_come_into_force_by_commit(void)
{
    expect_answer(&f, cam_err_params_begin, 0, stage, cam_param_lead_ns, 62000);
    expect_answer(&f, cam_err_params_begin, 0, commit, 0, 0);
    expect_answer(&f, cam_ok, 0, begin, 0, 0);
    expect_answer(&f, cam_ok, 62000, stage, cam_param_lead_ns, 62000);
    expect_answer(&f, cam_err_param_id, 0, stage, 255, 1);
    TEST_ASSERT_EQUAL_INT32(100000, f.rig.machine.params.lead_ns);
    expect_answer(&f, cam_ok, 1, commit, 0, 0);
    TEST_ASSERT_EQUAL_INT32(62000, f.rig.machine.params.lead_ns);
}

/// As with set_parameter: the refusal, the least and the largest value.
static void test_stage_out_of_range_is_answered_with_the_range(void)
{
    expect_answer(&f, cam_ok, 0, begin, 0, 0);
    const uint32_t n = hal_host.slow.n_sent;
    fixture_can_receive(0x640, 8, stage, cam_param_lead_ns, -1);
    fixture_can_loop(&f, 1);
    const int32_t values[] = {100000, 0, 20000000};
    for (uint32_t i = 0; i < 3u; i++) {
        const fixture_answer_t answer =
            fixture_can_answer(&hal_host.slow.sent[(n + i) % hal_host_can_frames]);
        TEST_ASSERT_EQUAL_INT32(i == 0u ? cam_err_param_range : cam_ok, answer.result);
        TEST_ASSERT_EQUAL_INT32(values[i], answer.value);
    }
}

static void test_saved_parameters_are_reverted_to(void)
{
    expect_answer(&f, cam_err_params_none, 0, revert, 0, 0);
    expect_answer(&f, cam_ok, 61000, set, cam_param_lead_ns, 61000);
    expect_answer(&f, cam_ok, 1, save, 0, 0);
    expect_answer(&f, cam_ok, 2, defaults, 0, 0);
    TEST_ASSERT_EQUAL_INT32(100000, f.rig.machine.params.lead_ns);
    expect_answer(&f, cam_ok, 3, revert, 0, 0);
    TEST_ASSERT_EQUAL_INT32(61000, f.rig.machine.params.lead_ns);
    hal_host.slow.n_store = 0;
    expect_answer(&f, cam_err_params_keep, 3, save, 0, 0);
}

static void test_status_tells_version_checksum_and_whether_they_are_kept(void)
{
    expect_answer(&f, cam_ok, 61000, set, cam_param_lead_ns, 61000);
    fixture_can_loop(&f, 1);
    for (uint32_t i = 0; i < 10000u && fixture_can_detail(21).id == 0u; i++) {
        fixture_can_loop(&f, 1);
    }
    const hal_can_frame_t frame = fixture_can_detail(21);
    TEST_ASSERT_EQUAL_HEX8(1u << 4 | cam_kept_none, frame.data[1]);
    TEST_ASSERT_EQUAL_HEX32(cam_param_store_checksum(&f.rig.machine.params),
                            (uint32_t)fixture_can_i32(&frame, 4));
}

static void test_refusal_is_told_field_by_field(void)
{
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_ready));
    expect_answer(&f, cam_err_spindle_speed, 0, set, cam_param_spindle_mrpm, 3500000);
    expect_answer(&f, cam_ok, cam_err_spindle_speed, refusal, cam_refusal_result, 0);
    expect_answer(&f, cam_ok, 3500000, refusal, cam_refusal_needed, 0);
    expect_answer(&f, cam_ok, 3000000, refusal, cam_refusal_limit, 0);
    expect_answer(&f, cam_ok, 3000000, refusal, cam_refusal_highest_mrpm, 0);
    expect_answer(&f, cam_ok, 0, refusal, cam_refusal_largest_feed_nm, 0);
    expect_answer(&f, cam_ok, 0, refusal, cam_refusal_pass, 0);
    expect_answer(&f, cam_ok, cam_n_params, refusal, cam_refusal_parameter, 0);
    expect_answer(&f, cam_err_param_id, 0, refusal, cam_n_refusals, 0);
    expect_answer(&f, cam_err_param_state, 1, set, cam_param_encoder_sign, -1);
    expect_answer(&f, cam_ok, cam_param_encoder_sign, refusal, cam_refusal_parameter, 0);
}
