// SPDX-License-Identifier: Apache-2.0
// Who commands over the bus, and what nobody can do over it: other senders, forged and old
// sessions, lost heartbeats, the locked level, a restart behind the emergency stop.
#include "cam_machine_hand.h"
#include "cam_machine_rights.h"
#include "expect_can.h"
#include "fixture_can.h"
#include "hal_host.h"
#include "monocypher.h"
#include "unity.h"
#include <string.h>

enum { enable = 1, disable, start, stop, reset, set, get, table_anew };
enum { home = 15, begin_download, end_download, set_learned = 29, manual, jog };
enum { begin_params = 50, stage, commit, save, defaults, revert };
enum { take = 60, release, beat, get_challenge, unlock, lock, last_command = lock };
enum { me = 1, other = 9, n_ms = 20 };

static fixture_can_t f;
static fixture_part_t part;
static uint8_t session;

static void begin(void)
{
    fixture_can_init(&f, &part, 20000);
}

static void run(void)
{
    fixture_can_start(&f);
    session = f.rig.machine.rights.session;
}

void setUp(void)
{
    part = fixture_part_short();
    begin();
    run();
}

void tearDown(void) {}

static fixture_answer_t by(uint8_t sender, uint8_t its_session, uint8_t command, int32_t value)
{
    return fixture_can_command_from(&f, command, 0, value, sender, its_session);
}

static void loop_until(cam_state_t wanted)
{
    expect_state_within(&f, wanted, 100000);
}

static void to_cutting(void)
{
    expect_answer(&f, cam_ok, 0, enable, 0, 0);
    loop_until(cam_state_ready);
    fixture_can_loop(&f, 2400); // the spindle runs up
    expect_answer(&f, cam_ok, 0, start, 0, 0);
    loop_until(cam_state_cutting);
}

/// @return page 25 of Detail, as new as can be
static hal_can_frame_t page(void)
{
    fixture_can_loop(&f, 800); // the port has forgotten the last one
    for (uint32_t i = 0; i < 30u * 200u && fixture_can_detail(25).id == 0u; i++) {
        fixture_can_loop(&f, 1);
    }
    return fixture_can_detail(25);
}

// Commander

/// @return whether there is such a command
static bool exists(uint8_t command)
{
    static const uint8_t gaps[] = {38, 39, 47, 48, 49};
    return memchr(gaps, command, sizeof gaps) == NULL;
}

static bool is_for_all(uint8_t command)
{
    static const uint8_t all[] = {4, 7, 9, 10, 20, 23, 28, 37, 46, 56, 57, 59, 60};
    return memchr(all, command, sizeof all) != NULL;
}

static void test_of_another_sender_only_reading_and_stop_are_obeyed(void)
{
    const struct {
        uint8_t sender, session;
    } strangers[] = {{0, 0}, {other, 0}, {other, session}, {me, 0}, {me, (uint8_t)(session + 1u)}};
    for (uint32_t i = 0; i < sizeof strangers / sizeof strangers[0]; i++) {
        for (uint8_t command = 1; command <= last_command; command++) {
            if (!is_for_all(command)) {
                const fixture_answer_t answer =
                    by(strangers[i].sender, strangers[i].session, command, 1);
                TEST_ASSERT_EQUAL_UINT32(command, answer.command);
                TEST_ASSERT_EQUAL_INT32(cam_err_not_commander, answer.result);
                TEST_ASSERT_EQUAL_INT32(exists(command) ? me : 0, answer.value);
            }
        }
        TEST_ASSERT_EQUAL_INT32(cam_ok,
                                by(strangers[i].sender, strangers[i].session, get, 0).result);
    }
    TEST_ASSERT_EQUAL_UINT32(0, hal_host.out.outputs & hal_out_enable);
    TEST_ASSERT_EQUAL_UINT32(session, f.rig.machine.rights.session);
}

static void test_an_old_session_is_void(void)
{
    const uint8_t old = session;
    fixture_can_take(&f);
    TEST_ASSERT_EQUAL_INT32(cam_err_not_commander, by(me, old, enable, 0).result);
    expect_answer(&f, cam_ok, 0, enable, 0, 0);
}

static void test_take_command_answers_who_has_it_or_the_session(void)
{
    fixture_answer_t answer = by(other, 0, take, 0);
    TEST_ASSERT_EQUAL_INT32(cam_err_not_commander, answer.result);
    TEST_ASSERT_EQUAL_INT32(me, answer.value);
    answer = by(other, 0, take, 1);
    TEST_ASSERT_EQUAL_INT32(cam_ok, answer.result);
    TEST_ASSERT_EQUAL_INT32(session + 1, answer.value);
    TEST_ASSERT_EQUAL_INT32(cam_ok, by(other, (uint8_t)answer.value, beat, 0).result);
    TEST_ASSERT_EQUAL_INT32(cam_ok, by(other, (uint8_t)answer.value, release, 0).result);
    TEST_ASSERT_EQUAL_INT32(cam_err_not_commander,
                            by(other, (uint8_t)answer.value, beat, 0).result);
    TEST_ASSERT_EQUAL_INT32(0, by(other, (uint8_t)answer.value, beat, 0).value);
    TEST_ASSERT_EQUAL_INT32(cam_err_frame, by(0, 0, take, 1).result);
}

static void test_anybody_stops_the_cut(void)
{
    to_cutting();
    TEST_ASSERT_EQUAL_INT32(cam_ok, by(0, 0, stop, 0).result);
    loop_until(cam_state_ready);
}

static void test_a_take_over_does_not_end_the_cut(void)
{
    to_cutting();
    const fixture_answer_t answer = by(other, 0, take, 1);
    fixture_can_loop(&f, 10u * n_ms);
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, fixture_rig_state());
    TEST_ASSERT_EQUAL_INT32(cam_err_not_commander, by(me, session, disable, 0).result);
    TEST_ASSERT_EQUAL_INT32(cam_ok, by(other, (uint8_t)answer.value, stop, 0).result);
}

/// @return [ticks] from now until the tool leaves the work
static uint32_t until_stopped(void)
{
    uint32_t n = 0;
    while (fixture_rig_state() == cam_state_cutting && n < 100000u) {
        fixture_can_loop(&f, 1);
        n++;
    }
    TEST_ASSERT_EQUAL_INT(cam_state_disengaging, fixture_rig_state());
    return n;
}

static void test_heartbeats_lost_in_the_cut_end_it_as_stop_does(void)
{
    expect_answer(&f, cam_ok, 5000, set, cam_param_feed_nm, 5000); // a cut of 4.8 s
    to_cutting();
    TEST_ASSERT_EQUAL_INT32(cam_ok, by(me, session, stop, 0).result);
    const uint32_t by_stop = until_stopped();
    loop_until(cam_state_ready);
    expect_answer(&f, cam_ok, 0, start, 0, 0);
    loop_until(cam_state_cutting);
    TEST_ASSERT_EQUAL_INT32(cam_ok, by(me, session, beat, 0).result);
    f.rig.is_silent = true;
    const uint32_t by_silence = until_stopped();
    // Both ends lie on a whole turn of the spindle: 2500 r/min are 480 ticks per turn.
    TEST_ASSERT_UINT32_WITHIN(2u * 480u, 20000u + by_stop, by_silence);
    loop_until(cam_state_ready);
    TEST_ASSERT_EQUAL_HEX32(0, fixture_rig_status(&f.rig).faults);
    TEST_ASSERT_EQUAL_INT32(cam_err_not_commander, by(me, session, start, 0).result);
    TEST_ASSERT_EQUAL_STRING("state ready", fixture_can_line(0));
    const hal_can_frame_t frame = page();
    TEST_ASSERT_EQUAL_UINT8(0, frame.data[1]); // nobody commands
    TEST_ASSERT_EQUAL_UINT8(1, frame.data[3]); // one loss
}

static void test_command_given_up_in_the_cut_ends_it_as_well(void)
{
    to_cutting();
    TEST_ASSERT_EQUAL_INT32(cam_ok, by(me, session, release, 0).result);
    loop_until(cam_state_ready);
}

static void test_a_start_on_its_way_does_not_outlive_its_commander(void)
{
    expect_answer(&f, cam_ok, 0, enable, 0, 0);
    loop_until(cam_state_ready);
    fixture_can_loop(&f, 2400);
    fixture_can_receive(0x640, 8, start, 0, 0);
    fixture_can_receive(0x640, 8, release, 0, 0);
    cam_can_poll(&f.can);
    cam_can_poll(&f.can); // both before the interrupt has taken the start
    fixture_can_loop(&f, 100);
    TEST_ASSERT_EQUAL_INT(cam_state_ready, fixture_rig_state());
}

static void test_heartbeats_lost_in_manual_brake_the_axes(void)
{
    expect_answer(&f, cam_ok, 0, manual, 0, 0);
    fixture_can_loop(&f, 20);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_step(&f.rig.machine, hal_axis_x, 50000000).err);
    f.rig.is_silent = true;
    for (uint32_t i = 0; i < 20000u - 40u; i++) { // what a step needs to go on, but no heartbeat
        if (i % 2000u == 0u) {
            cam_machine_hand_alive(&f.rig.machine);
        }
        fixture_can_loop(&f, 1);
    }
    TEST_ASSERT_NOT_EQUAL(0, f.rig.last.out[hal_axis_x].vel_q10);
    cam_machine_hand_alive(&f.rig.machine);
    fixture_can_loop(&f, 2000);
    TEST_ASSERT_EQUAL_INT32(0, f.rig.last.out[hal_axis_x].vel_q10);
    TEST_ASSERT_EQUAL_INT(cam_hand_stopped, fixture_rig_status(&f.rig).hand.end);
    TEST_ASSERT_EQUAL_INT(cam_state_manual, fixture_rig_state());
}

// Level

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
    uint8_t bytes[4];
    uint8_t hash[64];
    for (uint32_t i = 0; i < 4u; i++) {
        bytes[i] = (uint8_t)((uint32_t)asked.value >> (8u * i));
    }
    crypto_blake2b_keyed(hash, sizeof hash, secret, 22, bytes, sizeof bytes);
    const hal_can_frame_t as_frame = {.data = {hash[0], hash[1], hash[2], hash[3]}};
    const int32_t answer = fixture_can_i32(&as_frame, 0);
    expect_answer(&f, cam_err_unlock, 0, unlock, 0, answer ^ 1);
    fixture_can_loop(&f, 20000);
    const fixture_answer_t again = fixture_can_command(&f, get_challenge, 0, 0);
    for (uint32_t i = 0; i < 4u; i++) {
        bytes[i] = (uint8_t)((uint32_t)again.value >> (8u * i));
    }
    crypto_blake2b_keyed(hash, sizeof hash, secret, 22, bytes, sizeof bytes);
    const hal_can_frame_t new_frame = {.data = {hash[0], hash[1], hash[2], hash[3]}};
    expect_answer(&f, cam_ok, 0, unlock, 0, fixture_can_i32(&new_frame, 0));
    expect_answer(&f, cam_ok, 2000000, set, cam_param_u_stroke_nm, 2000000);
    fixture_can_loop(&f, 2);
    TEST_ASSERT_EQUAL_STRING("level: unlocked by the secret", fixture_can_line(0));
}

// Blocks

static void test_blocks_of_an_old_session_are_refused(void)
{
    static fixture_download_t d;
    fixture_download_init(&d);
    expect_begin(&d);
    expect_blocks(&d, 0, 1);
    fixture_can_take(&d.can);
    uint8_t message[4 + fixture_block_bytes];
    const uint32_t n = fixture_download_make(message, d.other.bytes, fixture_block_bytes,
                                             fixture_download_bytes(&d, 1));
    fixture_download_message(&d, message, n, 0);
    const hal_can_frame_t frame = fixture_can_sent(0x5C0);
    TEST_ASSERT_EQUAL_INT32(cam_err_not_commander, fixture_can_answer(&frame).result);
    TEST_ASSERT_EQUAL_UINT32(fixture_block_bytes, d.can.can.store.received);
    expect_begin(&d);
    expect_blocks(&d, 0, 1);
}

// Button

static void press(void)
{
    hal_host_press(true);
    fixture_can_loop(&f, 100u * n_ms);
    hal_host_press(false);
    fixture_can_loop(&f, 100u * n_ms);
}

/// Let everything come over the bus that could bring the drives back, for a while.
static void try_everything(void)
{
    // All but those that set numbers, download, and give command up.
    static const uint8_t moving[] = {1, 2, 3, 4, 5, 8, 15, 26, 27, 30, 31, 32, 33, 40, 41, 62};
    const int32_t x_nm = f.rig.last.out[hal_axis_x].pos_nm;
    const int32_t u_nm = f.rig.last.out[hal_axis_u].pos_nm;
    for (uint32_t i = 0; i < 20u; i++) {
        for (uint32_t k = 0; k < sizeof moving; k++) {
            (void)by(me, session, moving[k], (int32_t)i);
        }
        (void)by(me, session, reset, 0);
        TEST_ASSERT_EQUAL_INT32(cam_err_acknowledge, by(me, session, enable, 0).result);
        TEST_ASSERT_EQUAL_INT32(cam_err_acknowledge, by(me, session, home, 0).result);
        TEST_ASSERT_EQUAL_INT32(cam_err_acknowledge, by(me, session, manual, 0).result);
        fixture_can_loop(&f, 10u * n_ms);
        TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
        TEST_ASSERT_EQUAL_UINT32(0, hal_host.out.outputs & hal_out_enable);
        TEST_ASSERT_EQUAL_INT32(0, hal_host.out.spindle_mrpm);
        TEST_ASSERT_EQUAL_INT32(x_nm, f.rig.last.out[hal_axis_x].pos_nm);
        TEST_ASSERT_EQUAL_INT32(u_nm, f.rig.last.out[hal_axis_u].pos_nm);
    }
}

static void test_a_restart_behind_the_emergency_stop_by_the_bus_alone_is_impossible(void)
{
    begin();
    hal_host.slow.people = (hal_operator_t){.has_acknowledge = true, .has_key = true};
    run();
    fixture_can_loop(&f, 100u * n_ms);
    TEST_ASSERT_EQUAL_INT32(cam_err_acknowledge, by(me, session, enable, 0).result);
    press();
    to_cutting();
    hal_host_fault_estop(true);
    loop_until(cam_state_fault);
    fixture_can_loop(&f, 200u * n_ms);
    hal_host_fault_estop(false);
    fixture_can_loop(&f, 200u * n_ms);
    expect_answer(&f, cam_ok, 0, reset, 0, 0);
    loop_until(cam_state_off);
    try_everything();
    TEST_ASSERT_EQUAL_UINT8(0x01, page().data[4]); // the button is needed
    press();
    TEST_ASSERT_EQUAL_UINT8(0x11, page().data[4]); // given
    TEST_ASSERT_UINT8_WITHIN(1, 60, fixture_can_detail(25).data[5]);
    to_cutting();
}

// What is told

static void test_page_25_tells_commander_counts_and_level(void)
{
    hal_can_frame_t frame = page();
    const uint8_t at_first[] = {25, me, 0, 0, 0x31, 0};
    TEST_ASSERT_EQUAL_MEMORY(at_first, frame.data, sizeof at_first);
    TEST_ASSERT_UINT32_WITHIN(2, 600, frame.data[6] | (uint32_t)frame.data[7] << 8);
    hal_host_turn_key(false);
    (void)by(other, 0, take, 1);
    frame = page();
    const uint8_t then[] = {25, other, 1, 0, 0x30, 0, 0, 0};
    TEST_ASSERT_EQUAL_MEMORY(then, frame.data, sizeof then);
}

static void test_lines_tell_who_commands_and_who_was_refused(void)
{
    (void)by(other, 0, take, 1);
    fixture_can_loop(&f, 1);
    TEST_ASSERT_EQUAL_STRING("command: taken by 9 over from 1", fixture_can_line(1));
    TEST_ASSERT_EQUAL_STRING("level: locked", fixture_can_line(0)); // the key is still on
    (void)by(me, session, enable, 0);
    TEST_ASSERT_EQUAL_STRING("refused: command 1 of 1: the sender does not command: take_command "
                             "first",
                             fixture_can_line(0));
    const uint32_t n_lines = hal_host.n_lines;
    for (uint32_t i = 0; i < 1000u; i++) { // a babbler does not fill the log
        (void)by(me, session, enable, 0);
    }
    TEST_ASSERT_EQUAL_UINT32(n_lines, hal_host.n_lines);
    f.rig.is_silent = true;
    fixture_can_loop(&f, 20100);
    TEST_ASSERT_EQUAL_STRING("command: lost, nothing was heard of 9", fixture_can_line(0));
    fixture_can_take(&f);
    (void)by(me, f.rig.machine.rights.session, release, 0);
    fixture_can_loop(&f, 1);
    TEST_ASSERT_EQUAL_STRING("command: given up by 1", fixture_can_line(1));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_of_another_sender_only_reading_and_stop_are_obeyed);
    RUN_TEST(test_an_old_session_is_void);
    RUN_TEST(test_take_command_answers_who_has_it_or_the_session);
    RUN_TEST(test_anybody_stops_the_cut);
    RUN_TEST(test_a_take_over_does_not_end_the_cut);
    RUN_TEST(test_heartbeats_lost_in_the_cut_end_it_as_stop_does);
    RUN_TEST(test_command_given_up_in_the_cut_ends_it_as_well);
    RUN_TEST(test_a_start_on_its_way_does_not_outlive_its_commander);
    RUN_TEST(test_heartbeats_lost_in_manual_brake_the_axes);
    RUN_TEST(test_locked_limits_and_tables_stay_and_the_refusal_says_why);
    RUN_TEST(test_a_commit_that_changes_a_limit_is_refused_as_a_whole);
    RUN_TEST(test_what_would_bring_other_limits_into_force_or_keep_them_needs_the_key);
    RUN_TEST(test_never_in_the_work);
    RUN_TEST(test_a_port_without_key_and_secret_says_that_it_is_locked_for_good);
    RUN_TEST(test_the_secret_unlocks_by_its_challenge);
    RUN_TEST(test_blocks_of_an_old_session_are_refused);
    RUN_TEST(test_a_restart_behind_the_emergency_stop_by_the_bus_alone_is_impossible);
    RUN_TEST(test_page_25_tells_commander_counts_and_level);
    RUN_TEST(test_lines_tell_who_commands_and_who_was_refused);
    return UNITY_END();
}
