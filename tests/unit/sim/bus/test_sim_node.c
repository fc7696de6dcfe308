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

/// The node speaks; its frame with this identifier must be that.
static void expect_said(double t_s, uint32_t frame_id, uint32_t n, const uint8_t *bytes)
{
    speak(t_s);
    TEST_ASSERT_NOT_NULL(said(frame_id));
    TEST_ASSERT_EQUAL_UINT32(n, said(frame_id)->n);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(bytes, said(frame_id)->data, n);
}

static void expect_emcy(double t_s, uint32_t code)
{
    expect_said(t_s, 0x082, 8, (uint8_t[8]){(uint8_t)code, (uint8_t)(code >> 8), 1});
    speak(t_s);
    TEST_ASSERT_NULL(said(0x082));
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

static void enable(void)
{
    speak(0.0);
    manage(0x01, 0);
    wish(0x06, 0, 0.0);
    wish(0x07, 0, 0.0);
    wish(0x0F, 0, 0.0);
    TEST_ASSERT_TRUE(sim_cia402_is_following(&node.power));
}

static void test_node_boots_up_and_reports_its_state_at_the_heartbeat_rate(void)
{
    uint32_t n_beats = 0;
    expect_said(0.0, 0x702, 1, (uint8_t[]){canopen_boot_up});
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
    static const struct {
        uint32_t command, to, state;
    } steps[] = {{0x01, 3, canopen_pre_operational}, {0x01, id, canopen_operational},
                 {0x02, 0, canopen_stopped},         {0x80, id, canopen_pre_operational},
                 {0x55, 0, canopen_pre_operational}, {0x01, 0, canopen_operational}};
    for (uint32_t i = 0; i < sizeof steps / sizeof steps[0]; i++) {
        manage(steps[i].command, steps[i].to);
        TEST_ASSERT_EQUAL_UINT32(steps[i].state, node.nmt);
    }
    for (uint32_t reset = 0x81; reset <= 0x82u; reset++) {
        speak(0.0);
        manage(reset, 0);
        expect_said(0.001, 0x702, 1, (uint8_t[]){canopen_boot_up});
    }
}

/// Status and position of a drive, the position of an encoder, little endian.
static void test_pdos_need_the_state_operational(void)
{
    static const uint8_t bytes[] = {0x50, 0x02, 0x01, 0x00, 0x00, 0x80};
    speak(0.0);
    TEST_ASSERT_NULL(said(0x182));
    wish(0x06, 5, 0.0);
    TEST_ASSERT_EQUAL_INT32(0, node.active.target);
    manage(0x01, 0);
    expect_said(0.0, 0x182, 6, bytes);
    wish(0x06, 5, 0.0);
    TEST_ASSERT_EQUAL_INT32(5, node.active.target);
    sim_node_init(&node, id, false, HEARTBEAT_S);
    manage(0x01, 0);
    expect_said(0.0, 0x182, 4, bytes + 2);
    wish(0x06, 5, 0.0);
    TEST_ASSERT_EQUAL_INT32(0, node.active.target);
}

/// Frames of a wrong length are dropped with an emergency.
static void test_targets_take_effect_at_the_sync(void)
{
    static const struct {
        sim_frame_t frame;
        int32_t target, offset;
        bool is_wrong;
    } rows[] = {
        {{.id = 0x302, .n = 4, .data = {0x00, 0x01}}, 0, 0, false}, // with the next target
        {{.id = 0x202, .n = 6, .data = {0x0F, 0, 0xFE, 0xFF, 0xFF, 0xFF}}, -2, 256, false},
        {{.id = 0x202, .n = 12, .data = {0x0F, 0, 7, 0, 0, 0, 9}}, 7, 9, false},
        {{.id = 0x202, .n = 5, .data = {0x0F, 0, 3}}, 7, 9, true},
        {{.id = 0x302, .n = 3, .data = {3}}, 7, 9, true},
        {{.id = 0x203, .n = 6, .data = {0x0F, 0, 3}}, 7, 9, false},
    };
    enable();
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const sim_wish_t before = node.active;
        sim_node_receive(&node, &rows[i].frame, 0.001);
        TEST_ASSERT_EQUAL_INT32(before.target, node.active.target);
        sim_node_sync(&node, 0.001);
        TEST_ASSERT_EQUAL_INT32(rows[i].target, node.active.target);
        TEST_ASSERT_EQUAL_INT32(rows[i].offset, node.active.velocity_offset);
        if (rows[i].is_wrong) {
            expect_emcy(0.001, sim_emcy_pdo_length);
        }
    }
}

static void expect_failure(double t_s, uint32_t code)
{
    sim_node_guard(&node, t_s, GUARD_S);
    TEST_ASSERT_EQUAL(cia402_fault_reaction_active, node.power.state);
    expect_emcy(t_s, code);
}

/// A drive in operation fails when its RPDO or the SYNC stays away for longer than the guard time,
/// and when it is stopped; out of operation it waits for ever.
static void test_drive_is_guarded_in_operation(void)
{
    speak(0.0);
    manage(0x01, 0);
    wish(0x06, 0, 0.0);
    sim_node_guard(&node, 1000.0, GUARD_S);
    TEST_ASSERT_EQUAL(cia402_ready_to_switch_on, node.power.state);
    enable();
    sim_node_sync(&node, 0.0195);
    sim_node_guard(&node, 0.02, GUARD_S);
    TEST_ASSERT_TRUE(sim_cia402_is_following(&node.power));
    expect_failure(0.021, sim_emcy_rpdo_timeout);
    setUp();
    enable();
    sim_node_receive(&node, &(sim_frame_t){.id = 0x202, .n = 6, .data = {0x0F}}, 0.021);
    sim_node_guard(&node, 0.02, GUARD_S);
    TEST_ASSERT_TRUE(sim_cia402_is_following(&node.power));
    expect_failure(0.021, sim_emcy_sync_lost);
    setUp();
    enable();
    manage(0x80, 0);
    expect_failure(0.001, sim_emcy_rpdo_timeout);
}

static void test_dead_node_is_silent_and_deaf(void)
{
    enable();
    node.is_dead = true;
    wish(0x0F, 7, 0.001);
    speak(0.1);
    TEST_ASSERT_EQUAL_UINT32(0, out.n);
    TEST_ASSERT_EQUAL_INT32(0, node.active.target);
}

static void test_broken_heartbeat_leaves_the_pdos(void)
{
    enable();
    node.is_heartbeat_broken = true;
    speak(0.2);
    TEST_ASSERT_NULL(said(0x702));
    TEST_ASSERT_EQUAL_HEX32(drive_following, common_get_u16(said(0x182)->data) & 0x6Fu);
}
