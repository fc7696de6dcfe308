// SPDX-License-Identifier: Apache-2.0
// What needs the unlocked level over the bus, and how it is unlocked: limits, tables, and what is
// kept; never in the work.
#include "monocypher.h"
#include "rights_bench.h"

static void test_locked_limits_and_tables_stay_and_the_refusal_says_why(void)
{
    hal_host_turn_key(false);
    fixture_can_loop(&f, 2);
    expect_answer(&f, cam_err_locked, 1200000, set, cam_param_u_stroke_nm, 2000000);
    TEST_ASSERT_EQUAL_INT(cam_param_u_stroke_nm, f.rig.machine.refusal.param);
    expect_answer(&f, cam_err_locked, 0, table_anew, 0, 0);
    expect_answer(&f, cam_err_locked, 0, begin_download, 0, 1000);
    expect_answer(&f, cam_err_locked, 0, end_download, 0, 0);
    expect_answer(&f, cam_err_locked, 0, set_learned, 0, 0);
    expect_answer(&f, cam_ok, 5000000, set, cam_param_phase_udeg, 5000000);
    hal_host_turn_key(true);
    fixture_can_loop(&f, 2);
    expect_answer(&f, cam_ok, 2000000, set, cam_param_u_stroke_nm, 2000000);
}

/// The lock is for the bus: what is carried out for it ends with its answer.
static void test_what_is_set_at_the_machine_itself_needs_no_key(void)
{
    expect_answer(&f, cam_ok, 0, lock, 0, 0);
    expect_answer(&f, cam_err_locked, 1200000, set, cam_param_u_stroke_nm, 2000000);
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&f.rig, cam_param_u_stroke_nm, 2000000));
    expect_answer(&f, cam_err_locked, 2000000, set, cam_param_u_stroke_nm, 1200000);
}

static void test_a_commit_that_changes_a_limit_is_refused_as_a_whole(void)
{
    expect_answer(&f, cam_ok, 0, lock, 0, 0);
    (void)fixture_can_command(&f, begin_params, 0, 0);
    expect_answer(&f, cam_ok, 700000, stage, cam_param_amplitude_ppm, 700000);
    expect_answer(&f, cam_ok, 2000000, stage, cam_param_u_stroke_nm, 2000000);
    TEST_ASSERT_EQUAL_INT32(cam_err_locked, fixture_can_command(&f, commit, 0, 0).result);
    TEST_ASSERT_EQUAL_INT32(1000000, f.rig.machine.params.amplitude_ppm);
    expect_answer(&f, cam_ok, 1200000, stage, cam_param_u_stroke_nm, 1200000);
    TEST_ASSERT_EQUAL_INT32(cam_ok, fixture_can_command(&f, commit, 0, 0).result);
    TEST_ASSERT_EQUAL_INT32(700000, f.rig.machine.params.amplitude_ppm);
}

static void test_what_would_bring_other_limits_into_force_or_keep_them_needs_the_key(void)
{
    expect_answer(&f, cam_ok, 2000000, set, cam_param_u_stroke_nm, 2000000);
    expect_answer(&f, cam_ok, 0, lock, 0, 0);
    TEST_ASSERT_EQUAL_INT32(cam_err_locked, fixture_can_command(&f, save, 0, 0).result);
    TEST_ASSERT_EQUAL_INT32(cam_err_locked, fixture_can_command(&f, defaults, 0, 0).result);
    TEST_ASSERT_EQUAL_INT32(2000000, f.rig.machine.params.u_stroke_nm);
    fixture_can_take(&f);
    TEST_ASSERT_EQUAL_INT32(cam_ok, fixture_can_command(&f, save, 0, 0).result);
    expect_answer(&f, cam_ok, 1300000, set, cam_param_u_stroke_nm, 1300000);
    expect_answer(&f, cam_ok, 0, lock, 0, 0);
    TEST_ASSERT_EQUAL_INT32(cam_err_locked, fixture_can_command(&f, revert, 0, 0).result);
    fixture_can_take(&f);
    TEST_ASSERT_EQUAL_INT32(cam_ok, fixture_can_command(&f, revert, 0, 0).result);
    expect_answer(&f, cam_ok, 0, lock, 0, 0);
    expect_answer(&f, cam_ok, 3, set, cam_param_tool, 3); // an operator's parameter
    TEST_ASSERT_EQUAL_INT32(cam_ok, fixture_can_command(&f, save, 0, 0).result);
}

static void test_never_in_the_work(void)
{
    to_cutting();
    TEST_ASSERT_EQUAL_INT(cam_level_key, f.rig.machine.rights.level);
    for (uint32_t id = 0; id < (uint32_t)cam_n_params; id++) {
        if (cam_param_is_locked((cam_param_id_t)id)) {
            const int32_t value = cam_param_get(&f.rig.machine.params, (cam_param_id_t)id);
            expect_answer(&f, cam_err_param_state, value, set, (uint8_t)id, value);
        }
    }
    expect_answer(&f, cam_err_state, 0, table_anew, 0, 0);
    expect_answer(&f, cam_err_state, 0, begin_download, 0, 1000);
    TEST_ASSERT_EQUAL_INT32(cam_err_param_state, fixture_can_command(&f, set_learned, 0, 0).result);
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, fixture_rig_state());
}

static void test_a_port_without_key_and_secret_says_that_it_is_locked_for_good(void)
{
    begin();
    hal_host.slow.people.has_key = false;
    run();
    expect_answer(&f, cam_err_lock_none, 1200000, set, cam_param_u_stroke_nm, 2000000);
    TEST_ASSERT_EQUAL_INT32(cam_err_lock_none, fixture_can_command(&f, get_challenge, 0, 0).result);
}

/// @return what unlocks by a secret of n bytes behind a challenge
static int32_t response(const uint8_t *secret, size_t n, int32_t challenge)
{
    uint8_t bytes[4];
    uint8_t hash[64];
    for (uint32_t i = 0; i < 4u; i++) {
        bytes[i] = (uint8_t)((uint32_t)challenge >> (8u * i));
    }
    crypto_blake2b_keyed(hash, sizeof hash, secret, n, bytes, sizeof bytes);
    const hal_can_frame_t frame = {.data = {hash[0], hash[1], hash[2], hash[3]}};
    return fixture_can_i32(&frame, 0);
}

static void test_the_secret_unlocks_by_its_challenge(void)
{
    static const uint8_t secret[] = "sixteen bytes and some";
    begin();
    hal_host.slow.people =
        (hal_operator_t){.is_acknowledge_waived = true, .secret = secret, .n_secret = 22};
    run();
    expect_answer(&f, cam_err_locked, 1200000, set, cam_param_u_stroke_nm, 2000000);
    const fixture_answer_t asked = fixture_can_command(&f, get_challenge, 0, 0);
    TEST_ASSERT_EQUAL_INT32(cam_ok, asked.result);
    expect_answer(&f, cam_err_unlock, 0, unlock, 0, response(secret, 22, asked.value) ^ 1);
    fixture_can_loop(&f, 20000);
    const fixture_answer_t again = fixture_can_command(&f, get_challenge, 0, 0);
    expect_answer(&f, cam_ok, 0, unlock, 0, response(secret, 22, again.value));
    expect_answer(&f, cam_ok, 2000000, set, cam_param_u_stroke_nm, 2000000);
    fixture_can_loop(&f, 2);
    TEST_ASSERT_EQUAL_STRING("level: unlocked by the secret", fixture_can_line(0));
}
