// SPDX-License-Identifier: Apache-2.0
// Commands over CAN: every command and refusal, parameters, a queue without room. The bytes are
// those of camturn.dbc, written out by hand.
#include "cam_can.h"
#include "expect_can.h"
#include "fixture_can.h"
#include "hal_host.h"
#include "unity.h"

enum { enable = 1, disable, start, stop, reset, set, get, table_anew, get_minimum, get_maximum };
enum { set_speed = 11, set_feed, set_amplitude, set_phase, home };

static fixture_can_t f;
static fixture_part_t part;

void setUp(void)
{
    part = fixture_part_short();
    fixture_can_init(&f, &part, 20000);
    fixture_can_start(&f);
    const fixture_answer_t answer = fixture_can_command(&f, set, cam_param_lead_ns, 50000);
    TEST_ASSERT_EQUAL_INT32(50000, answer.value);
}

static void loop_until(cam_state_t wanted)
{
    expect_state_within(&f, wanted, 60000);
}

static void to_ready(void)
{
    expect_answer(&f, cam_ok, 0, enable, 0, 0);
    loop_until(cam_state_ready);
    fixture_can_loop(&f, 2400); // the spindle runs up
}

static void test_a_part_is_cut_by_commands(void)
{
    to_ready();
    expect_answer(&f, cam_ok, 0, start, 0, 0);
    loop_until(cam_state_cutting);
    expect_answer(&f, cam_ok, 0, stop, 0, 0);
    loop_until(cam_state_ready);
    expect_answer(&f, cam_ok, 0, disable, 0, 0);
    loop_until(cam_state_off);
}

static void test_a_command_before_the_last_was_taken_is_busy(void)
{
    fixture_can_receive(0x640, 8, enable, 0, 0);
    fixture_can_receive(0x640, 8, enable, 0, 0);
    cam_can_poll(&f.can);
    cam_can_poll(&f.can); // no tick in between
    const hal_can_frame_t frame = fixture_can_sent(0x5C0);
    TEST_ASSERT_EQUAL_INT32(cam_err_busy, fixture_can_answer(&frame).result);
}

static void test_an_infeasible_speed_is_refused_with_the_highest(void)
{
    expect_answer(&f, cam_ok, 3500000, set, cam_param_spindle_mrpm, 3500000);
    expect_answer(&f, cam_err_spindle_speed, 3000000, enable, 0, 0);
    expect_answer(&f, cam_ok, 2500000, set, cam_param_spindle_mrpm, 2500000);
    to_ready();
    expect_answer(&f, cam_err_spindle_speed, 2500000, set, cam_param_spindle_mrpm, 3500000);
    TEST_ASSERT_EQUAL_INT(cam_state_ready, fixture_rig_state());
}

static void test_set_tells_the_value_in_force(void)
{
    expect_answer(&f, cam_ok, -5000000, set, cam_param_phase_udeg, -5000000);
    expect_answer(&f, cam_err_param_range, -5000000, set, cam_param_phase_udeg, INT32_MIN);
    expect_answer(&f, cam_ok, -5000000, get, cam_param_phase_udeg, 77);
    expect_answer(&f, cam_err_param_tick, 200000, set, cam_param_observer_bandwidth_mHz, 1600001);
    expect_answer(&f, cam_err_param_id, 0, set, cam_n_params, 1);
    expect_answer(&f, cam_err_param_id, 0, get, 255, 1);
    expect_answer(&f, cam_ok, 0, enable, 0, 0);
    expect_answer(&f, cam_err_param_state, 0, set, cam_param_k1_ns, 1);
}

/// The last answers, oldest first, are a refusal and the range.
static void expect_range(uint8_t command, uint8_t index, int32_t low, int32_t high)
{
    const uint8_t commands[] = {command, get_minimum, get_maximum};
    const int32_t values[] = {0, low, high};
    for (uint32_t i = 0; i < 3u; i++) {
        const uint32_t at = hal_host.slow.n_sent - 3u + i;
        const fixture_answer_t answer =
            fixture_can_answer(&hal_host.slow.sent[at % hal_host_can_frames]);
        TEST_ASSERT_EQUAL_UINT32(commands[i], answer.command);
        TEST_ASSERT_EQUAL_UINT32(index, answer.index);
        TEST_ASSERT_EQUAL_INT32(i == 0u ? cam_err_param_range : cam_ok, answer.result);
        if (i > 0u) {
            TEST_ASSERT_EQUAL_INT32(values[i], answer.value);
        }
    }
}

static void test_a_value_out_of_range_is_answered_with_the_range(void)
{
    expect_answer(&f, cam_err_param_range, 0, set, cam_param_phase_udeg, INT32_MIN);
    expect_range(set, cam_param_phase_udeg, -180000000, 180000000);
    expect_answer(&f, cam_err_param_range, 1, set, cam_param_encoder_sign, 0);
    expect_range(set, cam_param_encoder_sign, -1, 1);
    (void)fixture_can_command(&f, set_speed, 0, -1);
    expect_range(set_speed, cam_param_spindle_mrpm, 0, 60000000);
    expect_answer(&f, cam_ok, 64, get_minimum, cam_param_counts_per_turn, 5);
    expect_answer(&f, cam_ok, 16777216, get_maximum, cam_param_counts_per_turn, 5);
    expect_answer(&f, cam_err_param_id, 0, get_minimum, cam_n_params, 5);
    expect_answer(&f, cam_err_param_id, 0, get_maximum, 255, 5);
}

static void test_a_range_without_room_is_kept(void)
{
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
    const hal_can_frame_t frame = fixture_can_sent(0x5C0);
    TEST_ASSERT_EQUAL_UINT32(get, fixture_can_answer(&frame).command);
}

static void test_quick_commands_set_their_parameters(void)
{
    expect_answer(&f, cam_ok, 1200500, set_speed, cam_param_spindle_mrpm, 1200500);
    TEST_ASSERT_EQUAL_INT32(1200500, f.rig.machine.params.spindle_mrpm);
    expect_answer(&f, cam_ok, 150000, set_feed, cam_param_feed_nm, 150000);
    TEST_ASSERT_EQUAL_INT32(150000, f.rig.machine.params.feed_nm);
    expect_answer(&f, cam_ok, 500000, set_amplitude, cam_param_amplitude_ppm, 500000);
    TEST_ASSERT_EQUAL_INT32(500000, f.rig.machine.params.amplitude_ppm);
    expect_answer(&f, cam_ok, -90000000, set_phase, cam_param_phase_udeg, -90000000);
    TEST_ASSERT_EQUAL_INT32(-90000000, f.rig.machine.params.phase_udeg);
}

static void test_only_ramped_parameters_change_in_the_cut(void)
{
    to_ready();
    expect_answer(&f, cam_ok, 0, start, 0, 0);
    loop_until(cam_state_cutting);
    for (int i = 0; i < cam_n_params; i++) {
        const cam_param_id_t id = (cam_param_id_t)i;
        const int32_t value = cam_param_get(&f.rig.machine.params, id);
        const bool may = id == cam_param_phase_udeg || id == cam_param_amplitude_ppm ||
                         id == cam_param_x_trim_nm || id == cam_param_feed_override_ppm ||
                         id == cam_param_spindle_override_ppm;
        expect_answer(&f, may ? cam_ok : cam_err_param_state, value, set, (uint8_t)i, value);
        fixture_can_loop(&f, 2);
    }
    expect_answer(&f, cam_err_param_state, 0, set_speed, cam_param_spindle_mrpm, 1000000);
    expect_answer(&f, cam_err_param_state, 0, set_feed, cam_param_feed_nm, 100000);
    expect_answer(&f, cam_ok, 900000, set_amplitude, cam_param_amplitude_ppm, 900000);
    fixture_can_loop(&f, 2);
    expect_answer(&f, cam_ok, 1000, set_phase, cam_param_phase_udeg, 1000);
    expect_answer(&f, cam_err_state, 0, home, 0, 0);
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, fixture_rig_state());
}

static void test_home_homes_and_homes_anew(void)
{
    expect_answer(&f, cam_ok, 0, home, 0, 0);
    loop_until(cam_state_homing);
    expect_answer(&f, cam_err_state, 0, home, 0, 0);
    loop_until(cam_state_ready);
    fixture_can_loop(&f, 2);
    expect_answer(&f, cam_ok, 0, home, 0, 0);
    loop_until(cam_state_off);
    TEST_ASSERT_EQUAL_HEX32(0, hal_host.out.outputs & hal_out_enable);
    loop_until(cam_state_homing);
    loop_until(cam_state_ready);
}

static void test_home_anew_stays_off_when_the_drives_are_not_ready(void)
{
    to_ready();
    expect_answer(&f, cam_ok, 0, home, 0, 0);
    hal_host_fault_drive(true);
    fixture_rig_tick(&f.rig);
    fixture_can_loop(&f, 10);
    hal_host_fault_drive(false);
    fixture_can_loop(&f, 10);
    TEST_ASSERT_EQUAL_INT(cam_state_off, fixture_rig_state());
}

static void test_get_knows_every_parameter(void)
{
    cam_params_t usual = cam_param_defaults();
    usual.lead_ns = 50000;
    usual.ripple_turns = 8;
    for (int i = 0; i < cam_n_params; i++) {
        const int32_t value = cam_param_get(&usual, (cam_param_id_t)i);
        expect_answer(&f, cam_ok, value, get, (uint8_t)i, 0);
    }
}

static void test_unknown_commands_have_an_error_of_their_own(void)
{
    expect_answer(&f, cam_err_command, 0, 0, 3, 1);
    expect_answer(&f, cam_err_command, 0, 18, 0, 0);
    expect_answer(&f, cam_err_command, 0, 199, 0, 0);
    expect_answer(&f, cam_err_command, 0, 255, 255, -1);
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
    hal_can_frame_t frame = fixture_can_sent(0x5C0);
    TEST_ASSERT_EQUAL_UINT32(get, fixture_can_answer(&frame).command);
    TEST_ASSERT_EQUAL_INT32(10, fixture_can_answer(&frame).value);
    TEST_ASSERT_EQUAL_INT32(20, f.rig.machine.params.engage_turns); // nothing waited any more
    hal_host.slow.n_room = 1;
    cam_can_poll(&f.can);
    frame = fixture_can_sent(0x5C0);
    TEST_ASSERT_EQUAL_UINT32(set, fixture_can_answer(&frame).command);
    TEST_ASSERT_EQUAL_INT32(20, fixture_can_answer(&frame).value);
    TEST_ASSERT_EQUAL_UINT32(n_sent + 2u, hal_host.slow.n_sent);
}

static void test_bus_off_stops_nothing_and_ends(void)
{
    to_ready();
    expect_answer(&f, cam_ok, 0, start, 0, 0);
    loop_until(cam_state_cutting);
    hal_host.slow.is_bus_off = true;
    const uint32_t n_sent = hal_host.slow.n_sent;
    fixture_can_receive(0x640, 8, get, 0, 0);
    fixture_can_loop(&f, 1000);
    TEST_ASSERT_EQUAL_UINT32(n_sent, hal_host.slow.n_sent);
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, fixture_rig_state());
    hal_host.slow.is_bus_off = false;
    fixture_can_loop(&f, 1);
    const hal_can_frame_t frame = fixture_can_sent(0x5C0);
    TEST_ASSERT_EQUAL_INT32(10000, fixture_can_answer(&frame).value);
}
