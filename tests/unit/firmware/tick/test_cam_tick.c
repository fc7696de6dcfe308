// SPDX-License-Identifier: Apache-2.0
// The tick of a whole controller: what it collects for learning, and a position beyond +-2^30 nm,
// which is limited and whose drive counts as not ready.
#include "fixture_rig.h"
#include "hal_host.h"
#include "unity.h"

enum { tick_hz = 20000 };

static fixture_rig_t rig;
static fixture_part_t part;

void setUp(void)
{
    part = fixture_part_short();
}

static void test_ticks_of_a_turn_in_the_cut_are_collected_for_learning(void)
{
    enum { ticks_per_turn = 60 * tick_hz / 2500 };
    fixture_rig_init(&rig, &part, tick_hz);
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    cam_turn_t turn;
    const cam_turn_bin_t *bin = NULL;
    for (int i = 0; i < 4 && bin == NULL; i++) {
        bin = cam_turn_bins_take(&g_cam.bins, &turn); // learning begins with the first call
        (void)cam_turn_bins_release(&g_cam.bins);
        fixture_rig_ticks(&rig, ticks_per_turn);
    }
    TEST_ASSERT_NOT_NULL(bin);
    int32_t n = 0;
    for (uint32_t i = 0; i < cam_turn_bins_n; i++) {
        n += bin[i].n;
    }
    TEST_ASSERT_GREATER_THAN_INT32(0, n);
}

static hal_axis_t far_axis; ///< axis whose position far_isr() replaces
static int32_t far_nm;

/// In the place of cam_isr(): one axis is measured elsewhere.
static void far_isr(void)
{
    hal_host.in.axis_nm[far_axis] = far_nm;
    cam_isr();
}

/// Measure an axis elsewhere for a tick. @return whether the tick senses drives that are ready
static bool is_ready_at(hal_axis_t axis, int32_t nm, int32_t sensed_nm)
{
    far_axis = axis;
    far_nm = nm;
    rig.isr = far_isr;
    fixture_rig_tick(&rig);
    rig.isr = NULL;
    TEST_ASSERT_EQUAL_INT32(sensed_nm, rig.last.in.actual_nm[axis]);
    return (rig.last.in.inputs & (uint32_t)hal_in_drive_ready) != 0u;
}

/// It is a fault, and in off a reason not to enable.
static void test_position_beyond_a_metre_is_a_drive_that_is_not_ready(void)
{
    enum { most_nm = 1 << 30 };
    for (uint32_t i = 0; i < 2u * hal_n_axes; i++) {
        const hal_axis_t axis = (hal_axis_t)(i / 2u);
        const bool is_low = i % 2u != 0u;
        fixture_rig_init(&rig, &part, tick_hz);
        TEST_ASSERT_FALSE(is_ready_at(axis, -most_nm - 1, -most_nm));
        TEST_ASSERT_EQUAL_INT(cam_err_drive, cam_machine_enable(&rig.machine));
        TEST_ASSERT_TRUE(is_ready_at(axis, -most_nm, -most_nm));
        TEST_ASSERT_TRUE(is_ready_at(axis, most_nm - 1, most_nm - 1));
        fixture_rig_init(&rig, &part, tick_hz);
        TEST_ASSERT_TRUE(fixture_rig_bring(&rig, is_low ? cam_state_cutting : cam_state_ready));
        TEST_ASSERT_FALSE(is_low ? is_ready_at(axis, INT32_MIN, -most_nm)
                                 : is_ready_at(axis, most_nm, most_nm - 1));
        TEST_ASSERT_EQUAL_INT(cam_state_fault, rig.last.want.state);
        TEST_ASSERT_BITS_HIGH(CAM_FAULT_BIT(drive), rig.last.want.faults);
        TEST_ASSERT_BITS_LOW(hal_out_enable, rig.last.want.outputs);
    }
}
