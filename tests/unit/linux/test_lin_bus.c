// SPDX-License-Identifier: Apache-2.0
// The Linux port's nodes together, on a bus without wires, whose frames come and go by calls: which
// node is lost, what is ready, who may use the bus, which frames a tick sends.
#include "canopen.h" // common_put_i32
#include "lin_bus.h" // lin_bus_t
#include "unity.h"   // TEST_ASSERT_TRUE
#include <stddef.h>  // NULL
#include <string.h>  // strlen

static const int64_t ms = 1000000;

static lin_config_t config;
static lin_bus_t bus;
static lin_commands_t commands;
static hal_can_frame_t frames[lin_bus_max_frames];
static uint32_t n_frames;
static int64_t now;

/// Let one tick pass; its frames are in `frames`.
static void make(void)
{
    n_frames = lin_bus_make(&bus, &commands, now, frames);
    now += ms;
}

/// Begin: the port listens for 100 ms and then sends at least the SYNC.
static void begin(void)
{
    lin_bus_init(&bus, &config);
    for (int i = 0; i <= 101; i++) {
        make();
        TEST_ASSERT_TRUE((n_frames != 0u) == (i == 101));
    }
}

/// Begin with a configuration of five nodes at 1 kHz.
void setUp(void)
{
    config = lin_config_defaults();
    config.thread.tick_hz = 1000;
    commands = (lin_commands_t){.outputs = 0};
    now = 1000 * ms;
    begin();
}

/// A frame arrives, its bytes given as two little-endian words.
static void hear(uint32_t id, uint32_t n, uint32_t low, uint32_t high)
{
    hal_can_frame_t frame = {.id = id, .n = n};
    common_put_i32(frame.data, (int32_t)low);
    common_put_i32(frame.data + 4, (int32_t)high);
    lin_bus_receive(&bus, &frame, now);
}

/// The heartbeat of a node in operation arrives.
static void beat(uint32_t node)
{
    hear(0x700 + node, 1, 5, 0);
}

/// Every node sends what is due, and the drives send this status word.
static void hear_all(uint32_t status)
{
    for (uint32_t node = 1; node <= 5u; node++) {
        beat(node);
    }
    hear(0x181, 4, (uint32_t)(now / 20000), 0); // 50 counts a tick
    for (uint32_t node = 2; node <= 5u; node++) {
        hear(0x180 + node, 6, status | node << 16, 0);
    }
}

/// Judge all nodes; these inputs and this cause of a loss must be the result.
static void expect(uint32_t inputs, lin_loss_t loss, uint32_t node)
{
    lin_bus_judge(&bus, now);
    TEST_ASSERT_EQUAL_HEX32(inputs, bus.inputs);
    TEST_ASSERT_EQUAL_INT(loss, bus.cause.loss);
    TEST_ASSERT_EQUAL_UINT32(node, bus.cause.node);
}

static void expect_ready(void)
{
    expect(hal_in_drive_ready, lin_loss_none, 0);
}

/// @return the frame of the last tick with this id, NULL when there is none
static const hal_can_frame_t *find(uint32_t id)
{
    for (uint32_t i = 0; i < n_frames; i++) {
        if (frames[i].id == id) {
            return &frames[i];
        }
    }
    return NULL;
}

static void expect_word(uint32_t node, uint32_t control_word)
{
    TEST_ASSERT_EQUAL_HEX16(control_word, common_get_u16(find(0x200 + node)->data));
}

/// Bring all drives into operation, enabled.
static void enable(void)
{
    hear_all(0x237);
    commands.outputs = hal_out_enable;
    make();
    hear_all(0x237);
    expect_ready();
}

/// The loss of the bus alone, and with that of the drives.
enum { lost = hal_in_drive_ready | hal_in_bus_lost, drives_lost = hal_in_bus_lost };

static void test_bus_is_lost_until_all_nodes_were_heard(void)
{
    expect(drives_lost, lin_loss_heartbeat, 1);
    hear_all(0x250);
    expect_ready();
}

static void test_each_node_that_is_silent_is_named(void)
{
    for (uint32_t node = 1; node <= 5u; node++) {
        setUp();
        enable();
        const int64_t heard = now;
        while (now - heard <= 100 * ms) { // all but the heartbeat
            hear(0x181, 4, (uint32_t)(now / 20000), 0);
            for (uint32_t other = 1; other <= 5u; other++) {
                hear(0x180 + other, 6, 0x237, 0);
                if (other != node) {
                    beat(other);
                }
            }
            expect_ready();
            now += ms;
        }
        const bool is_axis = node >= 2u && node <= 4u;
        hear(0x181, 4, (uint32_t)(now / 20000), 0);
        expect(is_axis ? drives_lost : lost, lin_loss_heartbeat, node);
    }
}

/// Encoder and spindle are losses of the bus, an axis in fault is not ready.
static void test_fault_of_one_node(void)
{
    enable();
    hear(0x081, 8, 0x5000, 0);
    expect(lost, lin_loss_emcy, 1);
    TEST_ASSERT_EQUAL_HEX16(0x5000, bus.cause.detail);
    setUp();
    enable();
    hear(0x185, 6, 0x218, 0);
    expect(lost, lin_loss_spindle, 5);
    setUp();
    enable();
    hear(0x182, 6, 0x218, 0);
    expect(0, lin_loss_none, 0);
    TEST_ASSERT_EQUAL_UINT32(2, bus.not_ready.node);
    setUp();
    hear_all(0x250);
    hear(0x185, 6, 0x218, 0); // while the drives are off
    expect(0, lin_loss_none, 0);
    TEST_ASSERT_EQUAL_UINT32(5, bus.not_ready.node);
}

static void test_loss_is_kept_while_the_fault_is_latched(void)
{
    enable();
    lin_bus_event(&bus, lin_loss_overflow);
    expect(lost, lin_loss_overflow, 0);
    commands.outputs = hal_out_enable | hal_out_fault; // the firmware's answer
    for (int i = 0; i < 10; i++) {
        make();
        hear_all(0x237);
        expect(lost, lin_loss_overflow, 0);
    }
    commands.outputs = 0; // reset
    make();
    hear_all(0x231);
    expect_ready();
}

static void test_link_that_is_down_takes_the_drives_along(void)
{
    static const lin_loss_t links[] = {lin_loss_bus_off, lin_loss_interface_down};
    for (uint32_t i = 0; i < 2u; i++) {
        setUp();
        enable();
        lin_bus_link(&bus, links[i]);
        expect(drives_lost, links[i], 0);
    }
}

static void test_what_only_a_controller_sends_is_another_one(void)
{
    static const uint32_t ids[] = {0x080, 0x740, 0x202, 0x203, 0x204, 0x205};
    for (uint32_t i = 0; i < sizeof ids / sizeof ids[0]; i++) {
        setUp();
        hear_all(0x250);
        hear(ids[i], 0, 0, 0);
        now += 100 * ms;
        hear_all(0x250);
        expect(lost, lin_loss_other_controller, 0);
        now += ms;
        hear_all(0x250);
        expect_ready();
    }
}

/// A controller is silent from the start and as long as another one is heard; then it begins.
static void test_whoever_comes_second_is_silent(void)
{
    lin_bus_init(&bus, &config);
    hear_all(0x237);
    make();
    expect(lost, lin_loss_listening, 0);
    for (int i = 0; i < 500; i++) {
        hear_all(0x237);
        hear(0x080, 0, 0, 0);
        commands.is_stopping = i > 400;
        expect(lost, lin_loss_other_controller, 0);
        make();
        TEST_ASSERT_EQUAL_UINT32(0, n_frames);
        TEST_ASSERT_TRUE(lin_bus_is_at_rest(&bus)); // they are the other's drives
    }
    commands.is_stopping = false;
    for (int i = 0; i < 100; i++) {
        make();
        TEST_ASSERT_EQUAL_UINT32(0, n_frames);
    }
    make();
    TEST_ASSERT_NOT_NULL(find(0x080));
    TEST_ASSERT_NOT_NULL(find(0x000));
    hear_all(0x250);
    expect_ready();
}

/// A controller that has begun brings its drives to rest, then it leaves the bus to the other one.
static void test_whoever_holds_drives_lets_go_before_it_is_silent(void)
{
    enable();
    hear(0x080, 0, 0, 0);
    make();
    TEST_ASSERT_NOT_NULL(find(0x080));
    commands.outputs = hal_out_fault;
    make();
    expect_word(2, 0x02);
    hear_all(0x250);
    make();
    TEST_ASSERT_EQUAL_UINT32(0, n_frames);
}

/// A node number is unused when no heartbeat of it came for as long as a heartbeat may stay away.
static void test_number_is_its_own_only_when_no_other_has_it(void)
{
    static const uint32_t ids[] = {0x740, 0x080};
    for (uint32_t i = 0; i < 2u; i++) {
        lin_bus_init(&bus, &config);
        for (int k = 0; k < 300; k++) {
            TEST_ASSERT_TRUE(bus.has_duplicate == (k <= 101 || ids[i] == 0x740u));
            hear(ids[i], ids[i] == 0x740u ? 1 : 0, 5, 0);
            make();
        }
    }
}

static void test_foreign_frames_change_nothing(void)
{
    enable();
    const lin_bus_t before = bus;
    hear(0x186, 6, 0x218, 0);
    hear(0x281, 8, 1, 1);
    hear(0x7FF, 8, 1, 1);
    hear(0x181, 8, 1, 1); // of a wrong length
    hear(0x182, 8, 1, 1);
    TEST_ASSERT_EQUAL_MEMORY(&before, &bus, sizeof bus);
}

static void expect_frame(uint32_t id, uint32_t n, uint32_t at, int32_t value)
{
    const hal_can_frame_t *const frame = find(id);
    TEST_ASSERT_NOT_NULL(frame);
    TEST_ASSERT_EQUAL_UINT32(n, frame->n);
    TEST_ASSERT_EQUAL_INT32(value, (int32_t)common_get_u32(frame->data + at));
}

/// FD puts the velocity behind the position.
static void test_tick_sends_setpoints_then_sync(void)
{
    enable();
    commands.axis[hal_axis_u] = (hal_setpoint_t){.pos_nm = -123456, .vel_q10 = 2048};
    commands.axis[hal_axis_z] = (hal_setpoint_t){.pos_nm = 7, .vel_q10 = -1024};
    commands.spindle_mrpm = -300000;
    make();
    TEST_ASSERT_EQUAL_UINT32(8, n_frames); // 3 x 2, spindle, SYNC
    TEST_ASSERT_EQUAL_HEX32(0x080, frames[7].id);
    TEST_ASSERT_EQUAL_UINT32(0, frames[7].n);
    expect_word(2, 0x0F);
    expect_frame(0x202, 6, 2, -123456);
    expect_frame(0x302, 4, 0, 2000); // 2 nm a tick at 1 kHz
    expect_frame(0x304, 4, 0, -1000);
    expect_frame(0x204, 6, 2, 7);
    expect_frame(0x205, 6, 2, -300000);
    TEST_ASSERT_NULL(find(0x305));
    config.can.is_fd = true;
    begin();
    enable();
    commands.axis[hal_axis_x] = (hal_setpoint_t){.pos_nm = 40000000, .vel_q10 = INT32_MAX};
    make();
    expect_frame(0x203, 12, 2, 40000000);
    expect_frame(0x203, 12, 6, 2097151999);
    TEST_ASSERT_EQUAL_HEX16(0, common_get_u16(find(0x203)->data + 10));
    TEST_ASSERT_NULL(find(0x303));
}

static void test_start_commands_all_nodes_and_then_beats(void)
{
    begin();
    TEST_ASSERT_EQUAL_UINT8(0, find(0x740)->data[0]); // boot-up
    TEST_ASSERT_EQUAL_UINT8(1, find(0x000)->data[0]);
    TEST_ASSERT_EQUAL_UINT8(0, find(0x000)->data[1]);
    uint32_t n_beats = 0;
    for (int i = 0; i < 500; i++) {
        make();
        TEST_ASSERT_NULL(find(0x000));
        const hal_can_frame_t *own = find(0x740);
        n_beats += own != NULL && own->data[0] == 5u ? 1u : 0u;
    }
    TEST_ASSERT_EQUAL_UINT32(10, n_beats);
}

static void test_node_that_comes_late_is_started_while_disabled_only(void)
{
    enable();
    make();
    hear(0x703, 1, 0x7F, 0);
    now += 200 * ms;
    make();
    TEST_ASSERT_NULL(find(0x000));
    commands.outputs = 0;
    make();
    TEST_ASSERT_EQUAL_UINT8(3, find(0x000)->data[1]);
}

static void test_stopping_leads_all_drives_to_rest(void)
{
    enable();
    commands.is_stopping = true;
    commands.spindle_mrpm = 300000;
    make();
    for (uint32_t node = 2; node <= 5u; node++) {
        expect_word(node, 0x02);
    }
    expect_frame(0x205, 6, 2, 0);
    TEST_ASSERT_FALSE(lin_bus_is_at_rest(&bus));
    hear_all(0x250);
    TEST_ASSERT_TRUE(lin_bus_is_at_rest(&bus));
    make();
    expect_word(2, 0x00);
}

static void test_axis_without_a_drive_reports_its_setpoint(void)
{
    config.drive[hal_axis_x].node = 0;
    config.spindle_node = 0;
    begin();
    for (uint32_t node = 1; node <= 4u; node++) {
        beat(node);
    }
    hear(0x181, 4, 0, 0);
    hear(0x182, 6, 0x250 | 9u << 16, 0);
    hear(0x184, 6, 0x250, 0);
    expect_ready();
    commands.axis[hal_axis_x].pos_nm = 55;
    TEST_ASSERT_EQUAL_INT32(55, lin_bus_actual_nm(&bus, hal_axis_x, &commands));
    TEST_ASSERT_EQUAL_INT32(9, lin_bus_actual_nm(&bus, hal_axis_u, &commands));
    make();
    TEST_ASSERT_NULL(find(0x200));
    TEST_ASSERT_NULL(find(0x203));
}

static void test_ids_are_those_that_are_taken(void)
{
    uint32_t ids[lin_bus_max_ids];
    const uint32_t n = lin_bus_ids(&bus, ids);
    TEST_ASSERT_EQUAL_UINT32(2 + 5 * 3 + 4, n);
    for (uint32_t i = 0; i < n; i++) {
        for (uint32_t k = 0; k < i; k++) {
            TEST_ASSERT_NOT_EQUAL_UINT32(ids[i], ids[k]);
        }
    }
}

static void expect_line(lin_cause_t cause, bool is_drives, const char *expected)
{
    char line[lin_line_bytes];
    const lin_cause_t same = lin_cause_unpack(lin_cause_pack(cause));
    (is_drives ? lin_cause_drives_text : lin_cause_bus_text)(same, &config, line, sizeof line);
    TEST_ASSERT_EQUAL_STRING(expected, line);
}

static void test_words_name_the_node_and_its_error(void)
{
    expect_line((lin_cause_t){.loss = lin_loss_none}, false, "bus: all nodes are heard");
    expect_line((lin_cause_t){.loss = lin_loss_bus_off}, false, "bus: bus-off");
    expect_line((lin_cause_t){lin_loss_heartbeat, 3, 0}, false,
                "bus: node 3 (drive x): no heartbeat");
    expect_line((lin_cause_t){lin_loss_emcy, 1, 0x5000}, false,
                "bus: node 1 (encoder): reports an error: error code 5000h");
    expect_line((lin_cause_t){.loss = lin_loss_none}, true, "drives: ready");
    expect_line((lin_cause_t){lin_loss_none, 5, 0xFF01}, true,
                "drives: node 5 (spindle) is not ready: error code FF01h");
    expect_line((lin_cause_t){lin_loss_pdo, 3, 0}, true,
                "drives: node 3 (drive x) is not ready: no measured values");
    for (int loss = 0; loss <= lin_loss_spindle; loss++) {
        TEST_ASSERT_GREATER_THAN(5, strlen(lin_loss_text((lin_loss_t)loss)));
    }
}
