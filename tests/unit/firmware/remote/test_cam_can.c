// SPDX-License-Identifier: Apache-2.0
// Commands over CAN: every command and refusal, parameters, frames that no tool should send, a
// queue without room, and a sector without a good table: the controller starts all the same,
// refuses to home and reports why. The bytes are those of camturn.dbc, written out by hand.
#include "can_bench.h"
#include <stdio.h>  // snprintf
#include <string.h> // memset, strlen

/// Home in ready homes anew: off, then as from off. A beat only waits for the next state.
static void test_each_command_leads_to_its_state(void)
{
    static const struct {
        uint8_t command;
        cam_err_t err;
        cam_state_t state;
    } steps[] = {
        {hold, cam_err_state, cam_state_off}, {resume, cam_err_state, cam_state_off},
        {home, cam_ok, cam_state_homing},     {home, cam_err_state, cam_state_ready},
        {home, cam_ok, cam_state_off},        {beat, cam_ok, cam_state_homing},
        {beat, cam_ok, cam_state_ready},      {start, cam_ok, cam_state_cutting},
        {hold, cam_ok, cam_state_holding},    {resume, cam_ok, cam_state_cutting},
        {stop, cam_ok, cam_state_ready},      {disable, cam_ok, cam_state_off},
    };
    for (uint8_t i = 0; i < sizeof steps / sizeof steps[0]; i++) {
        expect_answer(steps[i].err, 0, steps[i].command, i, 0);
        loop_until(steps[i].state);
        fixture_can_loop(&f, 2);
    }
}

static void test_a_command_before_the_last_was_taken_is_busy(void)
{
    static const uint8_t second[] = {enable, begin_download};
    for (uint32_t i = 0; i < sizeof second; i++) {
        setUp();
        fixture_can_receive(0x640, 8, enable, 0, 0);
        fixture_can_receive(0x640, 8, second[i], 0, 8000);
        cam_can_poll(&f.can);
        cam_can_poll(&f.can); // no tick in between
        TEST_ASSERT_EQUAL_INT32(cam_err_busy, last_answer().result);
    }
}

static void test_an_infeasible_speed_is_refused_with_the_highest(void)
{
    expect_answer(cam_ok, 3500000, set, cam_param_spindle_mrpm, 3500000);
    expect_answer(cam_err_spindle_speed, 3000000, enable, 0, 0);
    expect_answer(cam_ok, 2500000, set, cam_param_spindle_mrpm, 2500000);
    to_ready();
    expect_answer(cam_err_spindle_speed, 2500000, set, cam_param_spindle_mrpm, 3500000);
    TEST_ASSERT_EQUAL_INT(cam_state_ready, fixture_rig_state());
}

static void test_set_answers_the_value_in_force(void)
{
    expect_answer(cam_ok, -5000000, set, cam_param_phase_udeg, -5000000);
    expect_answer(cam_err_param_range, -5000000, set, cam_param_phase_udeg, INT32_MIN);
    expect_answer(cam_ok, -5000000, get, cam_param_phase_udeg, 77);
    expect_answer(cam_err_param_tick, 200000, set, cam_param_observer_bandwidth_mHz, 1600001);
    expect_answer(cam_err_param_id, 0, set, cam_n_params, 1);
    expect_answer(cam_err_param_id, 0, get, 255, 1);
    expect_answer(cam_ok, 0, enable, 0, 0);
    expect_answer(cam_err_param_state, 0, set, cam_param_k1_ns, 1);
}

/// @return the answer before the last n
static fixture_answer_t answer_before(uint32_t n)
{
    return fixture_can_answer(
        &hal_host.slow.sent[(hal_host.slow.n_sent - 1u - n) % hal_host_can_frames]);
}

/// The last answers, oldest first, are a refusal and the range.
static void expect_range(uint8_t command, uint8_t index, int32_t low, int32_t high)
{
    const fixture_answer_t refused = answer_before(2);
    expect_fields(refused, cam_err_param_range, refused.value, command, index);
    expect_fields(answer_before(1), cam_ok, low, get_minimum, index);
    expect_fields(answer_before(0), cam_ok, high, get_maximum, index);
}

/// Where there is no room for the range, it is kept.
static void test_a_value_out_of_range_is_answered_with_the_range(void)
{
    static const struct {
        uint8_t command, index;
        int32_t value, in_force;
        uint8_t param;
        int32_t low, high;
    } cases[] = {
        {set, cam_param_phase_udeg, INT32_MIN, 0, cam_param_phase_udeg, -180000000, 180000000},
        {set, cam_param_encoder_sign, 0, 1, cam_param_encoder_sign, -1, 1},
        {set, cam_param_spindle_override_ppm, 1300000, 1000000, cam_param_spindle_override_ppm,
         500000, 1200000},
        {stage, cam_param_lead_ns, -1, 100000, cam_param_lead_ns, 0, 20000000},
    };
    expect_answer(cam_ok, 0, begin_params, 0, 0);
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const fixture_answer_t answer =
            fixture_can_command(&f, cases[i].command, cases[i].index, cases[i].value);
        TEST_ASSERT_EQUAL_INT32(cases[i].in_force, answer.value);
        expect_range(cases[i].command, cases[i].param, cases[i].low, cases[i].high);
    }
    expect_answer(cam_ok, 64, get_minimum, cam_param_counts_per_turn, 5);
    expect_answer(cam_ok, 16777216, get_maximum, cam_param_counts_per_turn, 5);
    expect_answer(cam_err_param_id, 0, get_minimum, cam_n_params, 5);
    expect_answer(cam_err_param_id, 0, get_maximum, 255, 5);
    hal_host.slow.n_room = 2;
    const uint32_t n_sent = hal_host.slow.n_sent;
    fixture_can_receive(0x640, 8, set, cam_param_encoder_sign, 7);
    fixture_can_receive(0x640, 8, get, 0, 0);
    fixture_can_loop(&f, 3);
    TEST_ASSERT_EQUAL_UINT32(n_sent + 2u, hal_host.slow.n_sent);
    hal_host.slow.n_room = 1;
    cam_can_poll(&f.can);
    expect_range(set, cam_param_encoder_sign, -1, 1);
    hal_host.slow.n_room = 1;
    cam_can_poll(&f.can);
    TEST_ASSERT_EQUAL_UINT32(get, last_answer().command);
    hal_host.slow.n_room = 100;
    (void)fixture_can_command(&f, commit, 0, 0);
    expect_answer(cam_err_params_begin, 0, stage, cam_param_lead_ns, 5);
}

static void test_unknown_commands_have_an_error_of_their_own(void)
{
    static const uint8_t commands[][2] = {{0, 3}, {18, 0}, {199, 0}, {255, 255}};
    for (uint32_t i = 0; i < 4u; i++) {
        expect_answer(cam_err_command, 0, commands[i][0], commands[i][1], 1);
    }
    TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
}

static void test_an_answer_without_room_is_kept_before_the_next_command(void)
{
    hal_host.slow.n_room = 0;
    const uint32_t n_sent = hal_host.slow.n_sent;
    fixture_can_receive(0x640, 8, get, cam_param_engage_turns, 0);
    fixture_can_receive(0x640, 8, set, cam_param_engage_turns, 20);
    fixture_can_loop(&f, 3);
    TEST_ASSERT_EQUAL_UINT32(n_sent, hal_host.slow.n_sent);
    TEST_ASSERT_EQUAL_INT32(10, f.rig.machine.params.engage_turns); // not yet read
    hal_host.slow.n_room = 1;
    cam_can_poll(&f.can); // sends the first answer; the second finds no room again
    expect_fields(last_answer(), cam_ok, 10, get, cam_param_engage_turns);
    TEST_ASSERT_EQUAL_INT32(20, f.rig.machine.params.engage_turns); // nothing waited any more
    hal_host.slow.n_room = 1;
    cam_can_poll(&f.can);
    expect_fields(last_answer(), cam_ok, 20, set, cam_param_engage_turns);
    TEST_ASSERT_EQUAL_UINT32(n_sent + 2u, hal_host.slow.n_sent);
}

static void test_bus_off_stops_nothing_and_ends(void)
{
    to_cutting();
    hal_host.slow.is_bus_off = true;
    const uint32_t n_sent = hal_host.slow.n_sent;
    fixture_can_receive(0x640, 8, get, 0, 0);
    fixture_can_loop(&f, 1000);
    TEST_ASSERT_EQUAL_UINT32(n_sent, hal_host.slow.n_sent);
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, fixture_rig_state());
    hal_host.slow.is_bus_off = false;
    fixture_can_loop(&f, 1);
    TEST_ASSERT_EQUAL_INT32(10000, last_answer().value);
}

static void test_saved_parameters_are_reverted_to(void)
{
    expect_answer(cam_err_params_none, 0, revert, 0, 0);
    expect_answer(cam_ok, 61000, set, cam_param_lead_ns, 61000);
    expect_answer(cam_ok, 1, save, 0, 0);
    expect_answer(cam_ok, 2, defaults, 0, 0);
    TEST_ASSERT_EQUAL_INT32(100000, f.rig.machine.params.lead_ns);
    expect_answer(cam_ok, 3, revert, 0, 0);
    TEST_ASSERT_EQUAL_INT32(61000, f.rig.machine.params.lead_ns);
    hal_host.slow.n_store = 0;
    expect_answer(cam_err_params_keep, 3, save, 0, 0);
}

static void test_numbers_of_a_refusal_are_read_field_by_field(void)
{
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_ready));
    expect_answer(cam_err_spindle_speed, 0, set, cam_param_spindle_mrpm, 3500000);
    expect_answer(cam_ok, cam_err_spindle_speed, refusal, cam_refusal_result, 0);
    expect_answer(cam_ok, 3500000, refusal, cam_refusal_needed, 0);
    expect_answer(cam_ok, 3000000, refusal, cam_refusal_limit, 0);
    expect_answer(cam_ok, 3000000, refusal, cam_refusal_highest_mrpm, 0);
    expect_answer(cam_ok, 0, refusal, cam_refusal_largest_feed_nm, 0);
    expect_answer(cam_ok, 0, refusal, cam_refusal_pass, 0);
    expect_answer(cam_ok, cam_n_params, refusal, cam_refusal_parameter, 0);
    expect_answer(cam_err_param_id, 0, refusal, cam_n_refusals, 0);
    expect_answer(cam_err_param_state, 1, set, cam_param_encoder_sign, -1);
    expect_answer(cam_ok, cam_param_encoder_sign, refusal, cam_refusal_parameter, 0);
}

static void test_parts_are_set_and_read(void)
{
    expect_answer(cam_ok, 0, get_parts, 3, 0);
    expect_answer(cam_ok, 4711, set_parts, 5, 4711);
    expect_answer(cam_ok, 4711, get_parts, 3, 0);
    f.rig.machine.n_parts = UINT32_MAX;
    expect_answer(cam_ok, INT32_MAX, get_parts, 0, 0);
}

// By hand

enum { x_axis = 1, z_axis = 2 };

static int32_t position(uint8_t axis)
{
    fixture_can_loop(&f, 2000);
    return fixture_can_command(&f, get_position, axis, 0).value;
}

/// Wrong axes and values are refused, with the limit.
static void test_jog_and_step_move_their_axis(void)
{
    TEST_ASSERT_EQUAL_INT32(cam_err_state, result_of(jog, x_axis, 1));
    expect_answer(cam_ok, 0, manual, 0, 0);
    loop_until(cam_state_manual);
    TEST_ASSERT_EQUAL_INT32(cam_err_hand_axis, result_of(jog, 3, 1));
    TEST_ASSERT_EQUAL_INT32(cam_err_hand_axis, result_of(get_position, 200, 0));
    expect_answer(cam_err_hand_speed, 10000, jog, x_axis, INT32_MIN);
    const int32_t from_nm = position(x_axis);
    TEST_ASSERT_EQUAL_INT32(cam_ok, result_of(jog, x_axis, 5000));
    fixture_can_loop(&f, 20);
    TEST_ASSERT_EQUAL_INT32(cam_ok, result_of(jog, x_axis, 0));
    TEST_ASSERT_GREATER_THAN_INT32(from_nm + 100, position(x_axis));
    TEST_ASSERT_EQUAL_INT32(hal_host.out.axis[hal_axis_x].pos_nm, position(x_axis));
    TEST_ASSERT_EQUAL_INT32(cam_ok, result_of(step, z_axis, -1000));
    TEST_ASSERT_EQUAL_INT32(-1000, position(z_axis));
    TEST_ASSERT_EQUAL_INT(cam_state_manual, fixture_rig_state());
}

static void test_home_zero_and_tool_change_the_position(void)
{
    static const cam_param_id_t homes[] = {cam_param_u_home, cam_param_x_home, cam_param_z_home};
    for (uint32_t axis = 0; axis < (uint32_t)hal_n_axes; axis++) {
        TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&f.rig, homes[axis], 1));
    }
    expect_answer(cam_ok, 0, manual, 0, 0);
    loop_until(cam_state_manual);
    for (uint8_t axis = 0; axis < hal_n_axes; axis++) {
        TEST_ASSERT_EQUAL_INT32(cam_ok, result_of(home_axis, axis, 0));
        fixture_can_loop(&f, 20);
    }
    TEST_ASSERT_EQUAL_HEX32(7, fixture_rig_status(&f.rig).jog.homed);
    expect_answer(cam_ok, 40006000, zero_x, 0, 80012000);
    fixture_can_loop(&f, 20);
    expect_answer(cam_ok, -5, zero_z, 0, -5);
    fixture_can_loop(&f, 20);
    expect_answer(cam_ok, 3, set, cam_param_tool, 3);
    TEST_ASSERT_EQUAL_INT32(3, f.rig.machine.params.tool);
    TEST_ASSERT_EQUAL_INT32(cam_err_param_range, result_of(set, cam_param_tool, 5));
}

// Frames that no tool should send; tests/fuzz sends random ones

static void test_malformed_frames_are_answered_and_do_nothing(void)
{
    static const struct {
        hal_can_frame_t frame;
        cam_err_t err;
    } cases[] = {
        {{.n = 0, .data = {0}}, cam_err_frame},
        {{.n = 1, .data = {enable}}, cam_err_frame},
        {{.n = 2, .data = {enable, 9}}, cam_err_frame},
        {{.n = 7, .data = {enable, 9}}, cam_err_frame},
        {{.n = 12, .data = {enable, 9}}, cam_err_frame},
        {{.n = 64, .data = {enable, 9}}, cam_err_frame},
        {{.n = 8, .data = {enable, 0, 0x80}}, cam_err_not_commander},
        {{.n = 8, .data = {enable, 0, 0, 0x80}}, cam_err_not_commander},
    };
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const uint32_t n_sent = hal_host.slow.n_sent;
        hal_can_frame_t frame = cases[i].frame;
        frame.id = 0x640;
        (void)hal_host_can_receive(&frame);
        fixture_can_loop(&f, 1);
        TEST_ASSERT_EQUAL_UINT32(n_sent + 1u, hal_host.slow.n_sent);
        TEST_ASSERT_EQUAL_UINT32(8, fixture_can_sent(0x5C0).n);
        expect_fields(last_answer(), cases[i].err, last_answer().value, frame.data[0],
                      frame.data[1]);
        TEST_ASSERT_EQUAL_INT32(cases[i].err == cam_err_frame ? 0 : me, last_answer().value);
    }
    TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
}

/// Of those that come before a command, and of more than a poll reads.
static void test_foreign_ids_are_passed_over(void)
{
    const uint32_t n_sent = hal_host.slow.n_sent;
    static const uint32_t ids[] = {0, 0x63F, 0x641, 0x5C0, 0x1C0, 0x6C1, 0x540, 0x7FF};
    for (uint32_t i = 0; i < sizeof ids / sizeof ids[0]; i++) {
        fixture_can_receive(ids[i], 8, enable, 0, 0);
    }
    cam_can_poll(&f.can);
    TEST_ASSERT_EQUAL_UINT32(n_sent, hal_host.slow.n_sent);
    fixture_can_receive(0x123, 8, enable, 0, 0);
    expect_answer(cam_ok, 0, enable, 0, 0); // follows a foreign frame in the same poll
    for (uint32_t i = 0; i < hal_host_can_frames; i++) {
        fixture_can_receive(0x123, 8, 0, 0, 0);
    }
    const uint32_t n_read = hal_host.slow.n_read;
    cam_can_poll(&f.can);
    TEST_ASSERT_EQUAL_UINT32(n_read + 8u, hal_host.slow.n_read);
    cam_can_poll(&f.can);
    TEST_ASSERT_EQUAL_UINT32(hal_host.slow.n_received, hal_host.slow.n_read);
}

static void test_one_command_per_poll(void)
{
    fixture_can_receive(0x640, 8, get, 0, 0);
    fixture_can_receive(0x640, 8, get, 1, 0);
    const uint32_t n_sent = hal_host.slow.n_sent;
    cam_can_poll(&f.can);
    TEST_ASSERT_EQUAL_UINT32(n_sent + 1u, hal_host.slow.n_sent);
    cam_can_poll(&f.can);
    TEST_ASSERT_EQUAL_UINT32(n_sent + 2u, hal_host.slow.n_sent);
}

// Lines of text; test_cam_log_text.c has their words

static void test_a_long_line_is_cut_off(void)
{
    static char why[300];
    memset(why, 'w', sizeof why - 1u);
    hal_host.slow.start = (hal_start_t){.reset = hal_reset_halt, .why = why};
    fixture_can_start(&f);
    TEST_ASSERT_EQUAL_size_t(120, strlen(fixture_can_line(2)));
    TEST_ASSERT_EQUAL_STRING_LEN("start: halt: wwww", fixture_can_line(2), 17);
}

static fixture_image_t other;

static int32_t send(uint8_t command)
{
    return result_of(command, 0, 0);
}

/// @return the error in the status
static int32_t sent_err(void)
{
    fixture_can_loop(&f, 201);
    const hal_can_frame_t frame = fixture_can_sent(0x1C0);
    return fixture_can_i16(&frame, 2);
}

/// The line, the status and the answer to a home give the reason.
static void expect_no_table(cam_err_t err)
{
    char line[200];
    (void)snprintf(line, sizeof line, "table: %s - home refused until a table is written",
                   cam_err_text(err));
    TEST_ASSERT_EQUAL_STRING(line, fixture_can_line(0));
    TEST_ASSERT_EQUAL_INT32(err, sent_err());
    expect_answer(err, 0, enable, 0, 0);
}

/// The controller starts, refuses to home, and reports why.
static void expect_start_without_table(cam_err_t err)
{
    run();
    expect_no_table(err);
    TEST_ASSERT_EQUAL_INT32(err, send(select_table));
    fixture_can_loop(&f, 3);
    TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
}

static void expect_homing(void)
{
    fixture_can_loop(&f, 2);
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(enable));
    fixture_can_loop(&f, 2);
    TEST_ASSERT_EQUAL_INT(cam_state_homing, fixture_rig_state());
}

/// In a larger sector, whatever follows it there, and in one that it fills.
static void test_a_good_table_is_taken(void)
{
    TEST_ASSERT_EQUAL_STRING("table: short skirt in use", fixture_can_line(0));
    TEST_ASSERT_EQUAL_UINT32(f.rig.image.size, f.rig.machine.table.image_size);
    TEST_ASSERT_EQUAL_INT32(cam_ok, sent_err());
    expect_homing();
    begin();
    memset(&f.rig.image.bytes[f.rig.image.size], 0xA5, 128); // as long as an old signature
    run();
    expect_homing();
    begin();
    hal_host.slow.table.size = (uint32_t)f.rig.image.size;
    run();
    expect_homing();
}

/// No sector, erased ones, and those that end within header or image.
static void test_sectors_without_a_whole_table_are_refused(void)
{
    _Alignas(uint32_t) static const uint8_t short_one[8]; // the sanitizer sees a read beyond it
    static uint8_t erased[8192], zeros[8192];
    memset(erased, 0xFF, sizeof erased);
    const uint8_t *good = f.rig.image.bytes;
    const struct {
        const uint8_t *bytes;
        uint32_t size;
        cam_err_t err;
    } cases[] = {
        {NULL, 0, cam_err_no_table},
        {good, 0, cam_err_no_table},
        {NULL, 1024, cam_err_no_table},
        {erased, sizeof erased, cam_err_image_magic},
        {zeros, sizeof zeros, cam_err_image_magic},
        {good, 1, cam_err_image_size},
        {good, 20, cam_err_image_size},
        {good, 127, cam_err_image_size},
        {good, 128, cam_err_image_size},
        {good, 4192, cam_err_image_size},
        {short_one, sizeof short_one, cam_err_image_size},
    };
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        begin();
        hal_host.slow.table = (hal_image_t){.bytes = cases[i].bytes, .size = cases[i].size};
        expect_start_without_table(cases[i].err);
    }
}

static void test_select_takes_a_table_written_after_the_start_or_the_damage(void)
{
    f.rig.image.bytes[0] ^= 1u;
    expect_start_without_table(cam_err_image_magic);
    f.rig.image.bytes[0] ^= 1u;
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(select_table));
    TEST_ASSERT_EQUAL_STRING("table: short skirt in use", fixture_can_line(0));
    f.rig.image.bytes[1000] ^= 8u;
    fixture_can_loop(&f, 12); // two rounds of the check in the background
    expect_no_table(cam_err_image_crc);
    f.rig.image.bytes[1000] ^= 8u;
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(select_table));
    expect_homing();
}

static void test_select_of_an_overwritten_sector_forgets_the_table(void)
{
    fixture_image_put(&f.rig.image, fixture_at_version, 2);
    TEST_ASSERT_EQUAL_INT32(cam_err_image_version, send(select_table));
    expect_no_table(cam_err_image_version);
}

/// Its refusal is what is reported, also when the table in use is damaged later.
static void test_select_of_a_bad_table_elsewhere_keeps_the_one_in_use(void)
{
    memset(other.bytes, 0xFF, sizeof other.bytes);
    hal_host.slow.table.bytes = other.bytes;
    TEST_ASSERT_EQUAL_INT32(cam_err_image_magic, send(select_table));
    TEST_ASSERT_NULL(strstr(fixture_can_line(0), "home refused"));
    TEST_ASSERT_EQUAL_INT32(cam_err_image_magic, sent_err());
    expect_homing();
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(disable));
    fixture_can_loop(&f, 2);
    f.rig.image.bytes[1000] ^= 8u;
    fixture_can_loop(&f, 12);
    expect_no_table(cam_err_image_magic);
}

static void test_select_out_of_order_keeps_the_result_of_the_last_check(void)
{
    expect_homing();
    const uint32_t n_lines = hal_host.n_lines;
    TEST_ASSERT_EQUAL_INT32(cam_err_state, send(select_table));
    TEST_ASSERT_EQUAL_INT32(cam_ok, send(disable));
    fixture_can_receive(0x640, 8, set, cam_param_k1_ns, 5); // no tick has taken it yet
    cam_can_poll(&f.can);
    TEST_ASSERT_EQUAL_INT32(cam_err_busy, send(select_table));
    TEST_ASSERT_EQUAL_INT(cam_ok, f.can.store.err);
    fixture_can_loop(&f, 2);
    TEST_ASSERT_EQUAL_UINT32(n_lines + 1u, hal_host.n_lines); // state off
}
