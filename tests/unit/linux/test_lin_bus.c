// SPDX-License-Identifier: Apache-2.0
// The Linux port's nodes together: which node is lost, what is ready, who may use the bus.
#include "lin_bus_bench.h"

void setUp(void)
{
    bench_begin();
}

static void expect_cause(lin_loss_t loss, uint32_t node)
{
    TEST_ASSERT_EQUAL_INT(loss, bus.cause.loss);
    TEST_ASSERT_EQUAL_UINT32(node, bus.cause.node);
}

static void test_bus_is_lost_until_all_nodes_were_heard(void)
{
    TEST_ASSERT_EQUAL_HEX32(hal_in_bus_lost, judge());
    expect_cause(lin_loss_heartbeat, 1);
    hear_all(0x250);
    TEST_ASSERT_EQUAL_HEX32(hal_in_drive_ready, judge());
    expect_cause(lin_loss_none, 0);
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
            TEST_ASSERT_EQUAL_HEX32(hal_in_drive_ready, judge());
            now += ms;
        }
        const bool is_axis = node >= 2u && node <= 4u;
        hear(0x181, 4, (uint32_t)(now / 20000), 0);
        TEST_ASSERT_EQUAL_HEX32(is_axis ? hal_in_bus_lost : hal_in_bus_lost | hal_in_drive_ready,
                                judge());
        expect_cause(lin_loss_heartbeat, node);
    }
}

static void test_encoder_or_spindle_alone_leaves_the_drives_ready(void)
{
    enable();
    hear(0x081, 8, 0x5000, 0);
    TEST_ASSERT_EQUAL_HEX32(hal_in_drive_ready | hal_in_bus_lost, judge());
    expect_cause(lin_loss_emcy, 1);
    TEST_ASSERT_EQUAL_HEX16(0x5000, bus.cause.detail);
    setUp();
    enable();
    hear(0x185, 6, 0x218, 0); // fault
    TEST_ASSERT_EQUAL_HEX32(hal_in_drive_ready | hal_in_bus_lost, judge());
    expect_cause(lin_loss_spindle, 5);
}

static void test_spindle_in_fault_refuses_enable(void)
{
    hear_all(0x250);
    hear(0x185, 6, 0x218, 0);
    TEST_ASSERT_EQUAL_HEX32(0, judge());
    TEST_ASSERT_EQUAL_UINT32(5, bus.not_ready.node);
}

static void test_axis_in_fault_is_not_ready_but_no_loss(void)
{
    enable();
    hear(0x182, 6, 0x218, 0);
    TEST_ASSERT_EQUAL_HEX32(0, judge());
    expect_cause(lin_loss_none, 0);
    TEST_ASSERT_EQUAL_UINT32(2, bus.not_ready.node);
}

static void test_loss_is_kept_while_the_fault_is_latched(void)
{
    enable();
    lin_bus_event(&bus, lin_loss_overflow);
    TEST_ASSERT_EQUAL_HEX32(hal_in_drive_ready | hal_in_bus_lost, judge());
    commands.outputs = hal_out_enable | hal_out_fault; // the firmware's answer
    for (int i = 0; i < 10; i++) {
        make();
        hear_all(0x237);
        TEST_ASSERT_EQUAL_HEX32(hal_in_drive_ready | hal_in_bus_lost, judge());
        expect_cause(lin_loss_overflow, 0);
    }
    commands.outputs = 0; // reset
    make();
    hear_all(0x231);
    TEST_ASSERT_EQUAL_HEX32(hal_in_drive_ready, judge());
    expect_cause(lin_loss_none, 0);
}

static void test_link_that_is_down_takes_the_drives_along(void)
{
    static const lin_loss_t links[] = {lin_loss_bus_off, lin_loss_interface_down};
    for (uint32_t i = 0; i < 2u; i++) {
        setUp();
        enable();
        lin_bus_link(&bus, links[i]);
        TEST_ASSERT_EQUAL_HEX32(hal_in_bus_lost, judge());
        expect_cause(links[i], 0);
    }
}

static void test_what_only_a_controller_sends_is_another_one(void)
{
    static const uint32_t ids[] = {0x080, 0x740, 0x202, 0x203, 0x204, 0x205};
    for (uint32_t i = 0; i < sizeof ids / sizeof ids[0]; i++) {
        setUp();
        hear_all(0x250);
        hear(ids[i], 0, 0, 0);
        TEST_ASSERT_EQUAL_HEX32(hal_in_drive_ready | hal_in_bus_lost, judge());
        expect_cause(lin_loss_other_controller, 0);
        now += 101 * ms;
        hear_all(0x250);
        TEST_ASSERT_EQUAL_HEX32(hal_in_drive_ready, judge());
    }
}

/// A controller is silent from the start and as long as another one is heard; then it begins.
static void test_whoever_comes_second_is_silent(void)
{
    lin_bus_init(&bus, &config);
    hear_all(0x237);
    make();
    TEST_ASSERT_EQUAL_HEX32(hal_in_drive_ready | hal_in_bus_lost, judge());
    expect_cause(lin_loss_listening, 0);
    for (int i = 0; i < 500; i++) {
        hear_all(0x237);
        hear(0x080, 0, 0, 0);
        commands.is_stopping = i > 400;
        TEST_ASSERT_TRUE((judge() & hal_in_bus_lost) != 0u);
        expect_cause(lin_loss_other_controller, 0);
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
    TEST_ASSERT_EQUAL_HEX32(hal_in_drive_ready, judge());
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
    TEST_ASSERT_EQUAL_HEX16(0x02, common_get_u16(find(0x202)->data));
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
    setUp();
    TEST_ASSERT_FALSE(bus.has_duplicate);
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
