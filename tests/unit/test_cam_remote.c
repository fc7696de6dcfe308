// SPDX-License-Identifier: Apache-2.0
// Commands over CAN: every command and refusal, malformed frames, a queue without room. The bytes
// are those of cam_remote.h, written out.
#include "cam/cam_remote.h"
#include "fixture_remote.h"
#include "hal_host.h"
#include "unity.h"

enum { enable = 1, disable, start, stop, reset, set, get, table_anew };

static fixture_remote_t f;
static fixture_part_t part;

void setUp(void)
{
    part = fixture_part_short();
    fixture_remote_init(&f, &part, 20000);
    fixture_remote_start(&f);
    const fixture_answer_t answer = fixture_remote_command(&f, set, cam_param_lead_ns, 50000);
    TEST_ASSERT_EQUAL_INT32(50000, answer.value);
}

void tearDown(void) {}

static cam_state_t state(void)
{
    return fixture_rig_status(&f.rig).state;
}

static void expect(cam_err_t result, int32_t value, uint8_t command, uint8_t index, int32_t sent)
{
    const fixture_answer_t answer = fixture_remote_command(&f, command, index, sent);
    TEST_ASSERT_EQUAL_UINT32(command, answer.command);
    TEST_ASSERT_EQUAL_UINT32(index, answer.index);
    TEST_ASSERT_EQUAL_INT32(result, answer.result);
    TEST_ASSERT_EQUAL_INT32(value, answer.value);
}

static void loop_until(cam_state_t wanted)
{
    for (uint32_t i = 0; i < 60000u && state() != wanted; i++) {
        fixture_remote_loop(&f, 1);
    }
    TEST_ASSERT_EQUAL_INT(wanted, state());
}

static void to_ready(void)
{
    expect(cam_ok, 0, enable, 0, 0);
    loop_until(cam_state_ready);
    fixture_remote_loop(&f, 2400); // the spindle runs up
}

static void test_a_part_is_cut_by_commands(void)
{
    to_ready();
    expect(cam_ok, 0, start, 0, 0);
    loop_until(cam_state_cutting);
    expect(cam_ok, 0, stop, 0, 0);
    loop_until(cam_state_ready);
    expect(cam_ok, 0, disable, 0, 0);
    loop_until(cam_state_off);
}

static void test_a_fault_is_left_by_reset(void)
{
    to_ready();
    hal_host_fault_estop(true);
    loop_until(cam_state_fault);
    expect(cam_err_state, 0, enable, 0, 0);
    fixture_remote_loop(&f, 4000);
    expect(cam_ok, 0, reset, 0, 0);
    loop_until(cam_state_off);
    expect(cam_err_estop, 0, enable, 0, 0);
    hal_host_fault_estop(false);
    hal_host_fault_drive(true);
    fixture_rig_tick(&f.rig);
    expect(cam_err_drive, 0, enable, 0, 0);
}

static void test_commands_out_of_order_are_refused(void)
{
    for (uint8_t command = disable; command <= reset; command++) {
        expect(cam_err_state, 0, command, 0, 0);
    }
    to_ready();
    expect(cam_err_state, 0, enable, 0, 0);
    expect(cam_ok, 0, start, 0, 0);
    expect(cam_err_state, 0, start, 0, 0);
    expect(cam_err_state, 0, table_anew, 0, 0);
    TEST_ASSERT_EQUAL_INT(cam_state_engaging, state());
}

static void test_a_command_before_the_last_was_taken_is_busy(void)
{
    fixture_remote_receive(0x640, 8, enable, 0, 0);
    fixture_remote_receive(0x640, 8, enable, 0, 0);
    cam_remote_poll(&f.remote);
    cam_remote_poll(&f.remote); // no tick between them
    const hal_can_frame_t frame = fixture_remote_sent(0x5C0);
    TEST_ASSERT_EQUAL_INT32(cam_err_busy, fixture_remote_answer(&frame).result);
}

static void test_an_infeasible_speed_is_refused_with_the_highest(void)
{
    expect(cam_ok, 3500000, set, cam_param_spindle_mrpm, 3500000);
    expect(cam_err_spindle_speed, 3000000, enable, 0, 0);
    expect(cam_ok, 2500000, set, cam_param_spindle_mrpm, 2500000);
    to_ready();
    expect(cam_err_spindle_speed, 2500000, set, cam_param_spindle_mrpm, 3500000);
    TEST_ASSERT_EQUAL_INT(cam_state_ready, state());
}

static void test_set_tells_the_value_in_force(void)
{
    expect(cam_ok, -5000000, set, cam_param_phase_udeg, -5000000);
    expect(cam_err_param_range, -5000000, set, cam_param_phase_udeg, INT32_MIN);
    expect(cam_ok, -5000000, get, cam_param_phase_udeg, 77);
    expect(cam_err_param_tick, 200000, set, cam_param_observer_bandwidth_mHz, 1000001);
    expect(cam_err_param_id, 0, set, cam_n_params, 1);
    expect(cam_err_param_id, 0, get, 255, 1);
    expect(cam_ok, 0, enable, 0, 0);
    expect(cam_err_param_state, 0, set, cam_param_k1_ns, 1);
}

static void test_get_knows_every_parameter(void)
{
    for (int i = 0; i < cam_n_params; i++) {
        const int32_t value =
            i == cam_param_lead_ns ? 50000 : cam_param_info((cam_param_id_t)i)->def;
        expect(cam_ok, value, get, (uint8_t)i, 0);
    }
}

static void test_unknown_commands_have_an_error_of_their_own(void)
{
    expect(cam_err_command, 0, 0, 3, 1);
    expect(cam_err_command, 0, 9, 0, 0);
    expect(cam_err_command, 0, 255, 255, -1);
    TEST_ASSERT_EQUAL_INT(cam_state_off, state());
}

static fixture_answer_t answer_to(const hal_can_frame_t *frame)
{
    const uint32_t n_sent = hal_host.slow.n_sent;
    (void)hal_host_can_receive(frame);
    cam_remote_poll(&f.remote);
    TEST_ASSERT_EQUAL_UINT32(n_sent + 1u, hal_host.slow.n_sent);
    const hal_can_frame_t sent = fixture_remote_sent(0x5C0);
    TEST_ASSERT_EQUAL_UINT32(8, sent.n);
    return fixture_remote_answer(&sent);
}

static void test_malformed_frames_are_answered_and_do_nothing(void)
{
    static const uint32_t lengths[] = {0, 1, 2, 7, 12, 64};
    for (uint32_t i = 0; i < sizeof lengths / sizeof lengths[0]; i++) {
        const uint32_t n = lengths[i];
        const hal_can_frame_t frame = {.id = 0x640, .n = n, .data = {enable, 9}};
        const fixture_answer_t answer = answer_to(&frame);
        TEST_ASSERT_EQUAL_INT32(cam_err_frame, answer.result);
        TEST_ASSERT_EQUAL_UINT32(n > 0u ? enable : 0, answer.command);
        TEST_ASSERT_EQUAL_UINT32(n > 1u ? 9 : 0, answer.index);
        TEST_ASSERT_EQUAL_INT32(0, answer.value);
    }
    for (uint32_t at = 2; at < 4u; at++) {
        hal_can_frame_t frame = {.id = 0x640, .n = 8, .data = {enable}};
        frame.data[at] = 0x80;
        TEST_ASSERT_EQUAL_INT32(cam_err_frame, answer_to(&frame).result);
    }
    fixture_remote_loop(&f, 2);
    TEST_ASSERT_EQUAL_INT(cam_state_off, state());
}

static void test_foreign_ids_are_passed_over(void)
{
    const uint32_t n_sent = hal_host.slow.n_sent;
    static const uint32_t ids[] = {0, 0x63F, 0x641, 0x5C0, 0x180, 0x7FF};
    for (uint32_t i = 0; i < sizeof ids / sizeof ids[0]; i++) {
        fixture_remote_receive(ids[i], 8, enable, 0, 0);
    }
    cam_remote_poll(&f.remote);
    TEST_ASSERT_EQUAL_UINT32(n_sent, hal_host.slow.n_sent);
    fixture_remote_receive(0x123, 8, enable, 0, 0);
    expect(cam_ok, 0, enable, 0, 0); // behind a foreign one, in the same poll
}

static void test_a_flood_of_foreign_ids_does_not_hold_up_a_poll(void)
{
    for (uint32_t i = 0; i < hal_host_can_frames; i++) {
        fixture_remote_receive(0x123, 8, 0, 0, 0);
    }
    const uint32_t n_read = hal_host.slow.n_read;
    cam_remote_poll(&f.remote);
    TEST_ASSERT_EQUAL_UINT32(n_read + 8u, hal_host.slow.n_read);
    cam_remote_poll(&f.remote);
    TEST_ASSERT_EQUAL_UINT32(hal_host.slow.n_received, hal_host.slow.n_read);
}

static void test_one_command_per_poll(void)
{
    fixture_remote_receive(0x640, 8, get, 0, 0);
    fixture_remote_receive(0x640, 8, get, 1, 0);
    const uint32_t n_sent = hal_host.slow.n_sent;
    cam_remote_poll(&f.remote);
    TEST_ASSERT_EQUAL_UINT32(n_sent + 1u, hal_host.slow.n_sent);
    cam_remote_poll(&f.remote);
    TEST_ASSERT_EQUAL_UINT32(n_sent + 2u, hal_host.slow.n_sent);
}

static void test_an_answer_without_room_is_kept_before_the_next_command(void)
{
    hal_host.slow.n_room = 0;
    const uint32_t n_sent = hal_host.slow.n_sent;
    fixture_remote_receive(0x640, 8, get, cam_param_engage_turns, 0);
    fixture_remote_receive(0x640, 8, set, cam_param_engage_turns, 20);
    fixture_remote_loop(&f, 3);
    TEST_ASSERT_EQUAL_UINT32(n_sent, hal_host.slow.n_sent);
    TEST_ASSERT_EQUAL_INT32(10, f.rig.machine.params.engage_turns); // not yet read
    hal_host.slow.n_room = 1;
    cam_remote_poll(&f.remote); // sends the first answer; the second finds no room again
    hal_can_frame_t frame = fixture_remote_sent(0x5C0);
    TEST_ASSERT_EQUAL_UINT32(get, fixture_remote_answer(&frame).command);
    TEST_ASSERT_EQUAL_INT32(10, fixture_remote_answer(&frame).value);
    hal_host.slow.n_room = 1;
    cam_remote_poll(&f.remote);
    frame = fixture_remote_sent(0x5C0);
    TEST_ASSERT_EQUAL_UINT32(set, fixture_remote_answer(&frame).command);
    TEST_ASSERT_EQUAL_INT32(20, fixture_remote_answer(&frame).value);
    TEST_ASSERT_EQUAL_UINT32(n_sent + 2u, hal_host.slow.n_sent);
}

static void test_bus_off_stops_nothing_and_ends(void)
{
    to_ready();
    expect(cam_ok, 0, start, 0, 0);
    loop_until(cam_state_cutting);
    hal_host.slow.is_bus_off = true;
    const uint32_t n_sent = hal_host.slow.n_sent;
    fixture_remote_receive(0x640, 8, get, 0, 0);
    fixture_remote_loop(&f, 1000);
    TEST_ASSERT_EQUAL_UINT32(n_sent, hal_host.slow.n_sent);
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, state());
    hal_host.slow.is_bus_off = false;
    fixture_remote_loop(&f, 1);
    const hal_can_frame_t frame = fixture_remote_sent(0x5C0);
    TEST_ASSERT_EQUAL_INT32(10000, fixture_remote_answer(&frame).value);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_part_is_cut_by_commands);
    RUN_TEST(test_a_fault_is_left_by_reset);
    RUN_TEST(test_commands_out_of_order_are_refused);
    RUN_TEST(test_a_command_before_the_last_was_taken_is_busy);
    RUN_TEST(test_an_infeasible_speed_is_refused_with_the_highest);
    RUN_TEST(test_set_tells_the_value_in_force);
    RUN_TEST(test_get_knows_every_parameter);
    RUN_TEST(test_unknown_commands_have_an_error_of_their_own);
    RUN_TEST(test_malformed_frames_are_answered_and_do_nothing);
    RUN_TEST(test_foreign_ids_are_passed_over);
    RUN_TEST(test_a_flood_of_foreign_ids_does_not_hold_up_a_poll);
    RUN_TEST(test_one_command_per_poll);
    RUN_TEST(test_an_answer_without_room_is_kept_before_the_next_command);
    RUN_TEST(test_bus_off_stops_nothing_and_ends);
    return UNITY_END();
}
