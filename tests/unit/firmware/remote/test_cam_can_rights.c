// SPDX-License-Identifier: Apache-2.0
// Who commands over the bus, what needs the unlocked level, and what nobody can do over it: other
// senders, forged and old sessions, lost heartbeats, a restart after the emergency stop.
// test_cam_rights.c has the rules themselves.
#include "cam_machine.h" // cam_machine_step
#include "can_bench.h"
#include <string.h> // memchr

enum { other = 9, last_command = lock };

/// @return page 25 of Detail, as new as can be
static hal_can_frame_t page(void)
{
    fixture_can_loop(&f, 800); // the port has forgotten the last one
    for (uint32_t i = 0; i < 30u * 200u && fixture_can_detail(25).id == 0u; i += 8u) {
        fixture_rig_ticks(&f.rig, 7);
        fixture_can_loop(&f, 1);
    }
    return fixture_can_detail(25);
}

// Commander

static bool is_for_all(uint8_t command)
{
    static const uint8_t all[] = {4, 7, 9, 10, 20, 23, 28, 37, 46, 56, 57, 60};
    return memchr(all, command, sizeof all) != NULL;
}

static void test_of_another_sender_only_reading_and_stop_are_obeyed(void)
{
    static const uint8_t gaps[] = {11, 12, 13, 14, 36, 38, 39, 42, 43, 44, 47, 48, 49, 59, 63, 64};
    const struct {
        uint8_t sender, session;
    } strangers[] = {{0, 0}, {other, 0}, {other, session}, {me, 0}, {me, (uint8_t)(session + 1u)}};
    for (uint32_t i = 0; i < sizeof strangers / sizeof strangers[0]; i++) {
        for (uint8_t command = UINT8_MAX; command > 0u; command--) {
            if (command == take) {
                continue;
            }
            const fixture_answer_t answer =
                by(strangers[i].sender, strangers[i].session, command, 1);
            TEST_ASSERT_EQUAL_UINT32(command, answer.command);
            TEST_ASSERT_EQUAL(is_for_all(command), answer.result != cam_err_not_commander);
            if (!is_for_all(command)) {
                const bool exists = command <= last_command && !memchr(gaps, command, sizeof gaps);
                TEST_ASSERT_EQUAL_INT32(exists ? me : 0, answer.value);
            }
        }
    }
    TEST_ASSERT_EQUAL_UINT32(0, hal_host.out.outputs & hal_out_enable);
    TEST_ASSERT_EQUAL_UINT32(session, f.rig.machine.rights.session);
}

static void test_take_command_answers_who_has_it_or_the_session(void)
{
    const uint8_t next = (uint8_t)(session + 1u);
    const struct {
        uint8_t sender, session, command;
        int32_t sent;
        cam_err_t err;
        int32_t value;
    } steps[] = {
        {other, 0, take, 0, cam_err_not_commander, me},
        {other, 0, take, 1, cam_ok, next},
        {me, session, beat, 0, cam_err_not_commander, other}, // the old session is void
        {other, next, beat, 0, cam_ok, 0},
        {other, next, release, 0, cam_ok, 0},
        {other, next, beat, 0, cam_err_not_commander, 0},
        {0, 0, take, 1, cam_err_frame, 0},
    };
    for (uint32_t i = 0; i < sizeof steps / sizeof steps[0]; i++) {
        expect_fields(by(steps[i].sender, steps[i].session, steps[i].command, steps[i].sent),
                      steps[i].err, steps[i].value, steps[i].command, 0);
    }
}

/// A stop of anybody ends it.
static void test_a_take_over_does_not_end_the_cut(void)
{
    to_cutting();
    TEST_ASSERT_EQUAL_INT32(cam_ok, by(other, 0, take, 1).result);
    fixture_can_loop(&f, 10u * n_ms);
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, fixture_rig_state());
    TEST_ASSERT_EQUAL_INT32(cam_err_not_commander, by(me, session, disable, 0).result);
    TEST_ASSERT_EQUAL_INT32(cam_ok, by(0, 0, stop, 0).result);
    loop_until(cam_state_ready);
}

/// @return [ticks] from now until the tool leaves the work
static uint32_t until_stopped(void)
{
    const uint32_t n = fixture_can_until(&f, cam_state_cutting, false, 100000);
    TEST_ASSERT_EQUAL_INT(cam_state_disengaging, fixture_rig_state());
    return n;
}

static void test_heartbeats_lost_in_the_cut_end_it_as_stop_does(void)
{
    expect_answer(cam_ok, 5000, set, cam_param_feed_nm, 5000); // a cut of 4.8 s
    to_cutting();
    TEST_ASSERT_EQUAL_INT32(cam_ok, by(me, session, stop, 0).result);
    const uint32_t by_stop = until_stopped();
    loop_until(cam_state_ready);
    expect_answer(cam_ok, 0, start, 0, 0);
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

/// Any command of its session is a sign of life of the commander.
static void test_commands_keep_command_without_heartbeats(void)
{
    TEST_ASSERT_EQUAL_INT32(cam_ok, by(me, session, release, 0).result);
    session = (uint8_t)by(me, 0, take, 0).value;
    TEST_ASSERT_NOT_EQUAL(me, session);
    f.rig.is_silent = true;
    for (uint32_t i = 0; i < 5u; i++) {
        fixture_can_loop(&f, 15000);
        TEST_ASSERT_EQUAL_INT32(cam_ok, by(me, session, get, 0).result);
    }
    TEST_ASSERT_EQUAL_INT32(cam_ok, by(me, session, enable, 0).result);
    fixture_can_loop(&f, 25000);
    TEST_ASSERT_EQUAL_INT32(cam_err_not_commander, by(me, session, disable, 0).result);
}

/// Neither does a cut.
static void test_a_start_on_its_way_does_not_outlive_its_commander(void)
{
    to_ready();
    fixture_can_receive(0x640, 8, start, 0, 0);
    fixture_can_receive(0x640, 8, release, 0, 0);
    cam_can_poll(&f.can);
    cam_can_poll(&f.can); // both before the interrupt has taken the start
    fixture_can_loop(&f, 100);
    TEST_ASSERT_EQUAL_INT(cam_state_ready, fixture_rig_state());
    fixture_can_take(&f);
    expect_answer(cam_ok, 0, start, 0, 0);
    loop_until(cam_state_cutting);
    expect_answer(cam_ok, 0, release, 0, 0);
    loop_until(cam_state_ready);
}

static void test_heartbeats_lost_in_manual_brake_the_axes(void)
{
    expect_answer(cam_ok, 0, manual, 0, 0);
    fixture_can_loop(&f, 20);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_step(&f.rig.machine, hal_axis_x, 50000000).err);
    f.rig.is_silent = true;
    for (uint32_t i = 0; i < 20000u - 40u; i++) { // what a step needs to go on, but no heartbeat
        if (i % 2000u == 0u) {
            cam_machine_keep_alive(&f.rig.machine);
        }
        fixture_can_loop(&f, 1);
    }
    TEST_ASSERT_NOT_EQUAL(0, f.rig.last.out[hal_axis_x].vel_q10);
    cam_machine_keep_alive(&f.rig.machine);
    fixture_can_loop(&f, 2000);
    TEST_ASSERT_EQUAL_INT32(0, f.rig.last.out[hal_axis_x].vel_q10);
    TEST_ASSERT_EQUAL_INT(cam_jog_stopped, fixture_rig_status(&f.rig).jog.end);
    TEST_ASSERT_EQUAL_INT(cam_state_manual, fixture_rig_state());
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
    expect_answer(cam_ok, 0, reset, 0, 0);
    loop_until(cam_state_off);
    try_everything();
    TEST_ASSERT_EQUAL_UINT8(0x01, page().data[4]); // the button is needed
    press();
    TEST_ASSERT_EQUAL_UINT8(0x11, page().data[4]); // given
    TEST_ASSERT_UINT8_WITHIN(1, 60, fixture_can_detail(25).data[5]);
    to_cutting();
}

static void test_lines_name_the_commander_and_the_refused_sender(void)
{
    (void)by(other, 0, take, 1);
    fixture_can_loop(&f, 1);
    TEST_ASSERT_EQUAL_STRING("command: taken by 9 over from 1", fixture_can_line(1));
    TEST_ASSERT_EQUAL_STRING("level: locked", fixture_can_line(0)); // the key is still on
    for (uint32_t i = 0; i < 1000u; i++) {                          // a babbler gives one line
        (void)by(me, session, disable, 0);
    }
    TEST_ASSERT_EQUAL_STRING("refused: command 2 of 1: the sender does not have command: "
                             "take_command first",
                             fixture_can_line(0));
    TEST_ASSERT_EQUAL_STRING("level: locked", fixture_can_line(1));
}

// Level: limits, tables, and what is kept; never in the work

/// The lock is for the bus: what is set at the machine itself needs no key.
static void test_locked_limits_and_tables_stay_and_the_refusal_says_why(void)
{
    static const uint8_t locked[] = {select_table, begin_download, end_download, set_learned};
    hal_host_turn_key(false);
    fixture_can_loop(&f, 2);
    expect_answer(cam_err_locked, 1200000, set, cam_param_u_stroke_nm, 2000000);
    TEST_ASSERT_EQUAL_INT(cam_param_u_stroke_nm, f.rig.machine.refusal.param);
    for (uint32_t i = 0; i < sizeof locked; i++) {
        expect_answer(cam_err_locked, 0, locked[i], 0, 1000);
    }
    expect_answer(cam_ok, 5000000, set, cam_param_phase_udeg, 5000000);
    hal_host_turn_key(true);
    fixture_can_loop(&f, 2);
    expect_answer(cam_ok, 2000000, set, cam_param_u_stroke_nm, 2000000);
    expect_answer(cam_ok, 0, lock, 0, 0);
    expect_answer(cam_err_locked, 2000000, set, cam_param_u_stroke_nm, 1200000);
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&f.rig, cam_param_u_stroke_nm, 1200000));
    expect_answer(cam_err_locked, 1200000, set, cam_param_u_stroke_nm, 2000000);
}

static void test_a_commit_that_changes_a_limit_is_refused_as_a_whole(void)
{
    expect_answer(cam_ok, 0, lock, 0, 0);
    TEST_ASSERT_EQUAL_INT32(cam_ok, result_of(begin_params, 0, 0));
    expect_answer(cam_ok, 700000, stage, cam_param_amplitude_ppm, 700000);
    expect_answer(cam_ok, 2000000, stage, cam_param_u_stroke_nm, 2000000);
    TEST_ASSERT_EQUAL_INT32(cam_err_locked, result_of(commit, 0, 0));
    TEST_ASSERT_EQUAL_INT32(1000000, f.rig.machine.params.amplitude_ppm);
    expect_answer(cam_ok, 1200000, stage, cam_param_u_stroke_nm, 1200000);
    TEST_ASSERT_EQUAL_INT32(cam_ok, result_of(commit, 0, 0));
    TEST_ASSERT_EQUAL_INT32(700000, f.rig.machine.params.amplitude_ppm);
}

static void test_what_would_bring_other_limits_into_force_or_keep_them_needs_the_key(void)
{
    expect_answer(cam_ok, 2000000, set, cam_param_u_stroke_nm, 2000000);
    expect_answer(cam_ok, 0, lock, 0, 0);
    TEST_ASSERT_EQUAL_INT32(cam_err_locked, result_of(save, 0, 0));
    TEST_ASSERT_EQUAL_INT32(cam_err_locked, result_of(defaults, 0, 0));
    TEST_ASSERT_EQUAL_INT32(2000000, f.rig.machine.params.u_stroke_nm);
    fixture_can_take(&f);
    TEST_ASSERT_EQUAL_INT32(cam_ok, result_of(save, 0, 0));
    expect_answer(cam_ok, 1300000, set, cam_param_u_stroke_nm, 1300000);
    expect_answer(cam_ok, 0, lock, 0, 0);
    TEST_ASSERT_EQUAL_INT32(cam_err_locked, result_of(revert, 0, 0));
    fixture_can_take(&f);
    TEST_ASSERT_EQUAL_INT32(cam_ok, result_of(revert, 0, 0));
    expect_answer(cam_ok, 0, lock, 0, 0);
    expect_answer(cam_ok, 3, set, cam_param_tool, 3); // an operator's parameter
    TEST_ASSERT_EQUAL_INT32(cam_ok, result_of(save, 0, 0));
}

/// Only what is ramped changes there, whatever the level.
static void test_never_in_the_work(void)
{
    static const uint8_t ramped[] = {cam_param_phase_udeg, cam_param_amplitude_ppm,
                                     cam_param_x_trim_nm, cam_param_feed_override_ppm,
                                     cam_param_spindle_override_ppm};
    to_cutting();
    TEST_ASSERT_EQUAL_INT(cam_level_key, f.rig.machine.rights.level);
    for (uint32_t id = 0; id < (uint32_t)cam_n_params; id++) {
        const int32_t value = cam_param_get(&f.rig.machine.params, (cam_param_id_t)id);
        const bool may = memchr(ramped, (int)id, sizeof ramped) != NULL;
        expect_answer(may ? cam_ok : cam_err_param_state, value, set, (uint8_t)id, value);
        fixture_can_loop(&f, 2);
    }
    expect_answer(cam_err_state, 0, home, 0, 0);
    expect_answer(cam_err_state, 0, select_table, 0, 0);
    expect_answer(cam_err_state, 0, begin_download, 0, 1000);
    TEST_ASSERT_EQUAL_INT32(cam_err_param_state, result_of(set_learned, 0, 0));
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, fixture_rig_state());
}
