// SPDX-License-Identifier: Apache-2.0
// The Linux port's nodes together: which frames a tick sends.
#include "lin_bus_bench.h"

void setUp(void)
{
    bench_begin();
}

static int32_t i32(const hal_can_frame_t *frame, uint32_t at)
{
    return (int32_t)common_get_u32(frame->data + at);
}

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
    TEST_ASSERT_EQUAL_UINT32(6, find(0x202)->n);
    TEST_ASSERT_EQUAL_HEX16(0x0F, common_get_u16(find(0x202)->data));
    TEST_ASSERT_EQUAL_INT32(-123456, i32(find(0x202), 2));
    TEST_ASSERT_EQUAL_INT32(2000, i32(find(0x302), 0)); // 2 nm a tick at 1 kHz
    TEST_ASSERT_EQUAL_INT32(-1000, i32(find(0x304), 0));
    TEST_ASSERT_EQUAL_INT32(7, i32(find(0x204), 2));
    TEST_ASSERT_EQUAL_INT32(-300000, i32(find(0x205), 2));
    TEST_ASSERT_NULL(find(0x305));
}

static void test_fd_puts_the_velocity_behind_the_position(void)
{
    config.can.is_fd = true;
    begin();
    enable();
    commands.axis[hal_axis_x] = (hal_setpoint_t){.pos_nm = 40000000, .vel_q10 = INT32_MAX};
    make();
    TEST_ASSERT_EQUAL_UINT32(12, find(0x203)->n);
    TEST_ASSERT_EQUAL_INT32(40000000, i32(find(0x203), 2));
    TEST_ASSERT_EQUAL_INT32(2097151999, i32(find(0x203), 6));
    TEST_ASSERT_EQUAL_HEX16(0, common_get_u16(find(0x203)->data + 10));
    TEST_ASSERT_NULL(find(0x303));
}

static void test_start_tells_all_nodes_and_then_beats(void)
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
        TEST_ASSERT_EQUAL_HEX16(0x02, common_get_u16(find(0x200 + node)->data));
    }
    TEST_ASSERT_EQUAL_INT32(0, i32(find(0x205), 2));
    TEST_ASSERT_FALSE(lin_bus_is_at_rest(&bus));
    hear_all(0x250);
    TEST_ASSERT_TRUE(lin_bus_is_at_rest(&bus));
    make();
    TEST_ASSERT_EQUAL_HEX16(0x00, common_get_u16(find(0x202)->data));
}

static void test_axis_without_a_drive_tells_its_setpoint(void)
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
    TEST_ASSERT_EQUAL_HEX32(hal_in_drive_ready, judge());
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
