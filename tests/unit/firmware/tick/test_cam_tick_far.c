// SPDX-License-Identifier: Apache-2.0
// A measured position beyond +-2^30 nm is limited, and its drive counts as not ready.
#include "fixture_rig.h"
#include "hal_host.h"
#include "unity.h"

static fixture_rig_t rig;

static void begin(void)
{
    const fixture_part_t part = fixture_part_short();
    fixture_rig_init(&rig, &part, 20000);
}

static hal_axis_t far_axis; ///< axis whose position far_isr() replaces
static int32_t far_nm;

/// In the place of cam_isr(): one axis is measured elsewhere.
static void far_isr(void)
{
    hal_host.in.axis_nm[far_axis] = far_nm;
    cam_isr();
}

static void measure(hal_axis_t axis, int32_t nm)
{
    far_axis = axis;
    far_nm = nm;
    rig.isr = far_isr;
    fixture_rig_tick(&rig);
}

/// @return whether the last tick sensed drives that are ready, at a position
static bool is_ready_at(hal_axis_t axis, int32_t nm)
{
    TEST_ASSERT_EQUAL_INT32(nm, rig.last.in.actual_nm[axis]);
    return (rig.last.in.inputs & (uint32_t)hal_in_drive_ready) != 0u;
}

static void test_position_beyond_a_metre_is_a_drive_that_is_not_ready(void)
{
    static const cam_state_t states[] = {cam_state_ready, cam_state_cutting};
    for (uint32_t i = 0; i < 2u * hal_n_axes; i++) {
        const hal_axis_t axis = (hal_axis_t)(i / 2u);
        begin();
        TEST_ASSERT_TRUE(fixture_rig_bring(&rig, states[i % 2u]));
        measure(axis, i % 2u == 0u ? 1 << 30 : INT32_MIN);
        TEST_ASSERT_FALSE(is_ready_at(axis, i % 2u == 0u ? (1 << 30) - 1 : -(1 << 30)));
        TEST_ASSERT_EQUAL_INT(cam_state_fault, rig.last.want.state);
        TEST_ASSERT_BITS_HIGH(CAM_FAULT_BIT(drive), rig.last.want.faults);
        TEST_ASSERT_BITS_LOW(hal_out_enable, rig.last.want.outputs);
        rig.isr = NULL;
    }
}

static void test_enable_is_refused_while_a_position_is_beyond_a_metre(void)
{
    for (uint32_t axis = 0; axis < hal_n_axes; axis++) {
        begin();
        measure((hal_axis_t)axis, -(1 << 30) - 1);
        TEST_ASSERT_EQUAL_INT(cam_err_drive, cam_machine_enable(&rig.machine));
        fixture_rig_ticks(&rig, 100);
        TEST_ASSERT_EQUAL_INT(cam_state_off, rig.last.want.state);
        far_nm = -(1 << 30); // the first position that is accepted
        fixture_rig_ticks(&rig, 100);
        TEST_ASSERT_TRUE(is_ready_at((hal_axis_t)axis, -(1 << 30)));
        rig.isr = NULL;
    }
}
