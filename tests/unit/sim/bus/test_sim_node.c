// SPDX-License-Identifier: Apache-2.0
#include "canopen.h" // common_get_u32
#include "sim_bus.h"
#include "unity.h"

#define HEARTBEAT_S 0.05
#define GUARD_S 0.02

enum { id = 2, drive_following = 0x27 };

static sim_node_t node;
static sim_frames_t out;

void setUp(void)
{
    sim_node_init(&node, id, true, HEARTBEAT_S);
    out.n = 0;
}

static void speak(double t_s)
{
    out.n = 0;
    sim_node_send(&node, &out, 0x80000001u, t_s);
}

/// @return the queued frame with an identifier, NULL when there is none
static const sim_frame_t *said(uint32_t frame_id)
{
    for (uint32_t i = 0; i < out.n; i++) {
        if (out.frame[i].id == frame_id) {
            return &out.frame[i];
        }
    }
    return NULL;
}

static void manage(uint32_t command, uint32_t to)
{
    const sim_frame_t frame = {.n = 2, .data = {(uint8_t)command, (uint8_t)to}};
    sim_node_receive(&node, &frame, 0.0);
}

static void wish(uint32_t control_word, int32_t target, double t_s)
{
    sim_frame_t frame = {.id = 0x200 + id};
    sim_frame_put(&frame, control_word, 2);
    sim_frame_put(&frame, (uint32_t)target, 4);
    sim_node_receive(&node, &frame, t_s);
    sim_node_sync(&node, t_s);
}

static void enable(double t_s)
{
    speak(0.0);
    manage(0x01, 0);
    wish(0x06, 0, t_s);
    wish(0x07, 0, t_s);
    wish(0x0F, 0, t_s);
    TEST_ASSERT_TRUE(sim_cia402_is_following(&node.power));
}

static void test_node_boots_up_and_reports_its_state_at_the_heartbeat_rate(void)
{
    uint32_t n_beats = 0;
    speak(0.0);
    TEST_ASSERT_EQUAL_UINT8(canopen_boot_up, said(0x702)->data[0]);
    for (int i = 1; i <= 500; i++) {
        speak(i * 1e-3);
        if (said(0x702) != NULL) {
            n_beats++;
            TEST_ASSERT_EQUAL_UINT8(canopen_pre_operational, said(0x702)->data[0]);
        }
    }
    TEST_ASSERT_EQUAL_UINT32(10, n_beats);
}

static void test_network_management_reaches_the_addressed_node(void)
{
    manage(0x01, 3);
    TEST_ASSERT_EQUAL_UINT32(canopen_pre_operational, node.nmt);
    manage(0x01, id);
    TEST_ASSERT_EQUAL_UINT32(canopen_operational, node.nmt);
    manage(0x02, 0);
    TEST_ASSERT_EQUAL_UINT32(canopen_stopped, node.nmt);
    manage(0x80, 0);
    TEST_ASSERT_EQUAL_UINT32(canopen_pre_operational, node.nmt);
    speak(0.0);
    manage(0x81, 0);
    speak(0.001);
    TEST_ASSERT_EQUAL_UINT8(canopen_boot_up, said(0x702)->data[0]);
}

static void test_pdos_need_the_state_operational(void)
{
    speak(0.0);
    TEST_ASSERT_NULL(said(0x182));
    wish(0x06, 5, 0.0);
    TEST_ASSERT_EQUAL_INT32(0, node.active.target);
    manage(0x01, 0);
    wish(0x06, 5, 0.0);
    TEST_ASSERT_EQUAL_INT32(5, node.active.target);
}

static void test_tpdo_of_a_drive_has_status_and_position_little_endian(void)
{
    manage(0x01, 0);
    speak(0.0);
    const sim_frame_t *tpdo = said(0x182);
    static const uint8_t expected[] = {0x10, 0x02, 0x01, 0x00, 0x00, 0x80};
    TEST_ASSERT_EQUAL_UINT32(6, tpdo->n);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, tpdo->data, 6);
}

static void test_tpdo_of_an_encoder_has_its_position_only(void)
{
    static const uint8_t expected[] = {0x01, 0x00, 0x00, 0x80};
    sim_node_init(&node, id, false, HEARTBEAT_S);
    manage(0x01, 0);
    speak(0.0);
    TEST_ASSERT_EQUAL_UINT32(4, said(0x182)->n);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, said(0x182)->data, 4);
}

static void test_targets_take_effect_at_the_sync(void)
{
    enable(0.0);
    const sim_frame_t rpdo1 = {.id = 0x202, .n = 6, .data = {0x0F, 0, 0xFE, 0xFF, 0xFF, 0xFF}};
    const sim_frame_t rpdo2 = {.id = 0x302, .n = 4, .data = {0x00, 0x01}};
    sim_node_receive(&node, &rpdo1, 0.001);
    sim_node_receive(&node, &rpdo2, 0.001);
    TEST_ASSERT_EQUAL_INT32(0, node.active.target);
    sim_node_sync(&node, 0.001);
    TEST_ASSERT_EQUAL_INT32(-2, node.active.target);
    TEST_ASSERT_EQUAL_INT32(256, node.active.velocity_offset);
}

static void test_fd_frame_carries_all_three(void)
{
    enable(0.0);
    const sim_frame_t fd = {.id = 0x202, .n = 12, .data = {0x0F, 0, 7, 0, 0, 0, 9}};
    sim_node_receive(&node, &fd, 0.001);
    sim_node_sync(&node, 0.001);
    TEST_ASSERT_EQUAL_INT32(7, node.active.target);
    TEST_ASSERT_EQUAL_INT32(9, node.active.velocity_offset);
}

static void test_pdo_of_wrong_length_is_dropped_with_an_emergency(void)
{
    enable(0.0);
    const sim_frame_t rpdo = {.id = 0x202, .n = 5, .data = {0x0F, 0, 7}};
    sim_node_receive(&node, &rpdo, 0.001);
    sim_node_sync(&node, 0.001);
    TEST_ASSERT_EQUAL_INT32(0, node.active.target);
    speak(0.001);
    TEST_ASSERT_EQUAL_HEX8(0x10, said(0x082)->data[0]);
    TEST_ASSERT_EQUAL_HEX8(0x82, said(0x082)->data[1]);
    TEST_ASSERT_EQUAL_UINT32(8, said(0x082)->n);
    speak(0.002);
    TEST_ASSERT_NULL(said(0x082));
}

static void test_drive_fails_when_its_rpdo_stays_away_longer_than_the_guard_time(void)
{
    enable(0.0);
    sim_node_sync(&node, 0.0195);
    sim_node_guard(&node, 0.02, GUARD_S);
    TEST_ASSERT_TRUE(sim_cia402_is_following(&node.power));
    sim_node_guard(&node, 0.021, GUARD_S);
    TEST_ASSERT_EQUAL(cia402_fault_reaction_active, node.power.state);
    speak(0.021);
    TEST_ASSERT_EQUAL_HEX32(sim_emcy_rpdo_timeout, common_get_u16(said(0x082)->data));
}

static void test_drive_fails_when_sync_stays_away_though_rpdos_come(void)
{
    enable(0.0);
    const sim_frame_t rpdo = {.id = 0x202, .n = 6, .data = {0x0F}};
    sim_node_receive(&node, &rpdo, 0.021);
    sim_node_guard(&node, 0.021, GUARD_S);
    TEST_ASSERT_EQUAL(cia402_fault_reaction_active, node.power.state);
    speak(0.021);
    TEST_ASSERT_EQUAL_HEX32(sim_emcy_sync_lost, common_get_u16(said(0x082)->data));
}

static void test_drive_out_of_operation_may_wait_for_ever(void)
{
    speak(0.0);
    manage(0x01, 0);
    wish(0x06, 0, 0.0);
    sim_node_guard(&node, 1000.0, GUARD_S);
    TEST_ASSERT_EQUAL(cia402_ready_to_switch_on, node.power.state);
}

static void test_drive_stopped_by_the_network_fails(void)
{
    enable(0.0);
    manage(0x80, 0);
    sim_node_guard(&node, 0.001, GUARD_S);
    TEST_ASSERT_TRUE(sim_cia402_is_failed(&node.power));
}

static void test_dead_node_is_silent_and_deaf(void)
{
    enable(0.0);
    node.is_dead = true;
    wish(0x0F, 7, 0.001);
    speak(0.1);
    TEST_ASSERT_EQUAL_UINT32(0, out.n);
    TEST_ASSERT_EQUAL_INT32(0, node.active.target);
}

static void test_broken_heartbeat_leaves_the_pdos(void)
{
    enable(0.0);
    node.is_heartbeat_broken = true;
    speak(0.2);
    TEST_ASSERT_NULL(said(0x702));
    TEST_ASSERT_EQUAL_HEX32(drive_following, common_get_u16(said(0x182)->data) & 0x6Fu);
}
