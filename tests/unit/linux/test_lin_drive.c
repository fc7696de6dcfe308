// SPDX-License-Identifier: Apache-2.0
// The Linux port's drives: states and control words of CiA 402, readiness, scales.
#include "lin_bus.h"
#include "canopen.h" // common_put_u16
#include "unity.h"

enum { node = 2 };
static const int64_t ms = 1000000;

static const lin_timeouts_t timeouts = {
    .node_ns = 100000000, .pdo_ns = 20000000, .enable_ns = 500000000};
static lin_drive_t d;

void setUp(void)
{
    lin_drive_init(&d, node, 1, 1);
}

static void hear(uint16_t status, int32_t actual, int64_t ns)
{
    hal_can_frame_t frame = {.id = canopen_id_tpdo1 + node, .n = 6};
    common_put_u16(frame.data, status);
    common_put_i32(frame.data + 2, actual);
    TEST_ASSERT_TRUE(lin_drive_receive(&d, &frame, ns));
    const hal_can_frame_t beat = {.id = canopen_id_heartbeat + node, .n = 1, .data = {5}};
    TEST_ASSERT_TRUE(lin_drive_receive(&d, &beat, ns));
}

static void emcy(uint16_t code)
{
    hal_can_frame_t frame = {.id = canopen_id_emcy + node, .n = 8};
    common_put_u16(frame.data, code);
    TEST_ASSERT_TRUE(lin_drive_receive(&d, &frame, 0));
}

static void expect(bool is_ready, lin_loss_t loss, int64_t now_ns)
{
    lin_drive_judge(&d, now_ns, &timeouts);
    TEST_ASSERT_EQUAL(is_ready, d.is_ready);
    TEST_ASSERT_EQUAL_INT(loss, d.loss);
}

/// All status words are compared with the table of the standard.
static void test_states_are_those_of_the_standard(void)
{
    static const struct {
        const char *pattern; // bits 6 5 . 3 2 1 0; x: any
        cia402_state_t state;
    } rows[] = {{"0xx0000", cia402_not_ready_to_switch_on}, {"1xx0000", cia402_switch_on_disabled},
                {"01x0001", cia402_ready_to_switch_on},     {"01x0011", cia402_switched_on},
                {"01x0111", cia402_operation_enabled},      {"00x0111", cia402_quick_stop_active},
                {"0xx1111", cia402_fault_reaction_active},  {"0xx1000", cia402_fault}};
    for (uint32_t status = 0; status < 0x10000u; status++) {
        cia402_state_t expected = cia402_not_ready_to_switch_on; // also for what cannot be
        for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
            bool fits = true;
            for (uint32_t k = 0; k < 7u; k++) {
                const char wanted = rows[i].pattern[6u - k];
                fits = fits && (wanted == 'x' || (wanted == '1') == ((status >> k & 1u) != 0u));
            }
            expected = fits ? rows[i].state : expected;
        }
        TEST_ASSERT_EQUAL_INT(expected, lin_cia402_state((uint16_t)status));
    }
}

static void test_control_words_lead_to_the_goal(void)
{
    static const lin_cia402_goal_t goals[] = {lin_cia402_rest, lin_cia402_enabled, lin_cia402_off,
                                              lin_cia402_reset};
    static const struct {
        cia402_state_t state;
        uint16_t word[4];
    } rows[] = {{cia402_not_ready_to_switch_on, {0x06, 0x00, 0x00, 0x06}},
                {cia402_switch_on_disabled, {0x06, 0x06, 0x00, 0x06}},
                {cia402_ready_to_switch_on, {0x06, 0x07, 0x00, 0x06}},
                {cia402_switched_on, {0x06, 0x0F, 0x00, 0x06}},
                {cia402_operation_enabled, {0x02, 0x0F, 0x02, 0x02}},
                {cia402_quick_stop_active, {0x02, 0x02, 0x02, 0x02}},
                {cia402_fault_reaction_active, {0x06, 0x00, 0x00, 0x06}},
                {cia402_fault, {0x06, 0x00, 0x00, 0x80}}};
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        for (uint32_t k = 0; k < 4u; k++) {
            TEST_ASSERT_EQUAL_HEX16(rows[i].word[k], lin_cia402_control(rows[i].state, goals[k]));
        }
    }
}

static void test_drive_that_is_heard_is_ready_until_it_is_silent(void)
{
    expect(false, lin_loss_heartbeat, 0);
    hear(0x250, 7, 10 * ms);
    expect(true, lin_loss_none, 30 * ms);
    TEST_ASSERT_EQUAL_INT32(7, lin_drive_actual_nm(&d));
    expect(false, lin_loss_pdo, 30 * ms + 1);
    expect(false, lin_loss_pdo, 110 * ms);
    expect(false, lin_loss_heartbeat, 110 * ms + 1);
}

static void test_drive_with_an_error_is_not_ready(void)
{
    static const uint16_t bad[] = {0x200, 0x21F, 0x218}; // not ready, fault reaction, fault
    for (uint32_t i = 0; i < 3u; i++) {
        hear(bad[i], 0, 10 * ms);
        expect(false, lin_loss_none, 10 * ms);
    }
    hear(0x250, 0, 10 * ms);
    emcy(0x8611);
    expect(false, lin_loss_none, 10 * ms);
    emcy(0);
    expect(true, lin_loss_none, 10 * ms);
    emcy(0x8611);
    lin_drive_forget(&d);
    expect(true, lin_loss_none, 10 * ms);
}

static void test_enabled_drive_must_follow_in_time_and_stay(void)
{
    lin_drive_enable(&d, true, 0);
    for (int64_t t = 0; t < 500; t++) {
        hear(0x231, 0, t * ms);
        expect(true, lin_loss_none, t * ms);
    }
    hear(0x231, 0, 500 * ms);
    expect(false, lin_loss_none, 500 * ms);
    lin_drive_enable(&d, false, 500 * ms);
    expect(true, lin_loss_none, 500 * ms);
    lin_drive_enable(&d, true, 501 * ms); // the time begins anew
    expect(true, lin_loss_none, 501 * ms);
    hear(0x237, 0, 502 * ms);
    expect(true, lin_loss_none, 502 * ms);
    hear(0x231, 0, 503 * ms); // fell out
    expect(false, lin_loss_none, 503 * ms);
}

static void test_fault_is_reset_once_a_second_where_it_may(void)
{
    uint32_t n = 0;
    hear(0x218, 0, 0);
    emcy(0x8611);
    for (int64_t t = 0; t < 2500; t++) {
        TEST_ASSERT_EQUAL_HEX16(0x06, lin_drive_control(&d, t * ms, false, false));
    }
    for (int64_t t = 2500; t < 5000; t++) {
        n += lin_drive_control(&d, t * ms, true, false) == 0x80 ? 1u : 0u;
    }
    TEST_ASSERT_EQUAL_UINT32(3, n);
    TEST_ASSERT_EQUAL_HEX16(0, d.node.emcy);
}

static void test_drive_that_stays_in_quick_stop_loses_its_voltage(void)
{
    hear(0x217, 0, 1);
    TEST_ASSERT_EQUAL_HEX16(0x02, lin_drive_control(&d, 1, false, true));
    TEST_ASSERT_EQUAL_HEX16(0x02, lin_drive_control(&d, 2000 * ms, false, true));
    TEST_ASSERT_EQUAL_HEX16(0x00, lin_drive_control(&d, 2001 * ms, false, true));
}

static void test_node_that_boots_or_stops_is_lost_and_commanded_to_start(void)
{
    hal_can_frame_t frame;
    hear(0x250, 0, 0);
    hal_can_frame_t beat = {.id = canopen_id_heartbeat + node, .n = 1, .data = {0}};
    TEST_ASSERT_FALSE(lin_node_start(&d.node, 200 * ms, &frame));
    (void)lin_drive_receive(&d, &beat, 1);
    beat.data[0] = 5;
    (void)lin_drive_receive(&d, &beat, 2); // as quick as that: still noticed
    expect(false, lin_loss_restarted, 2);
    expect(true, lin_loss_none, 3);
    beat.data[0] = 0x7F;
    (void)lin_drive_receive(&d, &beat, 4);
    expect(false, lin_loss_not_operational, 5);
    TEST_ASSERT_TRUE(lin_node_start(&d.node, 200 * ms, &frame));
    TEST_ASSERT_EQUAL_UINT32(0, frame.id);
    TEST_ASSERT_EQUAL_UINT32(2, frame.n);
    TEST_ASSERT_EQUAL_UINT8(1, frame.data[0]);
    TEST_ASSERT_EQUAL_UINT8(node, frame.data[1]);
    TEST_ASSERT_FALSE(lin_node_start(&d.node, 299 * ms, &frame));
    TEST_ASSERT_TRUE(lin_node_start(&d.node, 300 * ms, &frame));
}

static void test_foreign_and_malformed_frames_are_left_alone(void)
{
    hear(0x237, 5, 0);
    hal_can_frame_t frame = {.id = canopen_id_tpdo1 + node, .n = 5};
    TEST_ASSERT_FALSE(lin_drive_receive(&d, &frame, 1));
    frame.id = canopen_id_tpdo1 + node + 1;
    frame.n = 6;
    TEST_ASSERT_FALSE(lin_drive_receive(&d, &frame, 1));
    frame.id = canopen_id_heartbeat + node; // six bytes
    TEST_ASSERT_FALSE(lin_drive_receive(&d, &frame, 1));
    TEST_ASSERT_EQUAL_INT(cia402_operation_enabled, d.state);
    lin_drive_init(&d, 0, 1, 1);
    frame.id = canopen_id_tpdo1;
    TEST_ASSERT_FALSE(lin_drive_receive(&d, &frame, 1));
    expect(true, lin_loss_none, 0); // a drive that does not exist is ready
}

static void test_scales_round_clamp_and_turn_round(void)
{
    TEST_ASSERT_EQUAL_INT32(-123, lin_drive_units(&d, -123));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, lin_drive_units(&d, INT64_C(5000000000)));
    TEST_ASSERT_EQUAL_UINT32(1000, lin_drive_unit_pm(&d));
    lin_drive_init(&d, node, 4096, -5000000); // 5 mm screw, 12 bits, turned round
    TEST_ASSERT_EQUAL_INT32(-4096, lin_drive_units(&d, 5000000));
    TEST_ASSERT_EQUAL_INT32(1, lin_drive_units(&d, -611));
    TEST_ASSERT_EQUAL_INT32(0, lin_drive_units(&d, -610));
    TEST_ASSERT_EQUAL_UINT32(1220703, lin_drive_unit_pm(&d));
    hear(0x237, 2, 0);
    TEST_ASSERT_EQUAL_INT32(-2441, lin_drive_actual_nm(&d));
    hear(0x237, INT32_MIN, 0);
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, lin_drive_actual_nm(&d));
    lin_drive_init(&d, 0, 131072, 5000000); // no drive, no unit
    TEST_ASSERT_EQUAL_UINT32(0, lin_drive_unit_pm(&d));
}
