// SPDX-License-Identifier: Apache-2.0
// What goes wrong outside ends the work of a whole controller in time. Each limit, and where its
// fault is armed, is judged by test_cam_guard_limits.c.
#include "rig_bench.h"
#include <math.h>

static void expect_within(cam_fault_t fault, uint32_t ticks)
{
    const uint32_t passed = fixture_rig_until(&rig, cam_state_fault, ticks + 1u);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32_MESSAGE(ticks, passed, cam_fault_name(fault));
    const cam_status_t status = fixture_rig_status(&rig);
    TEST_ASSERT_BITS_HIGH_MESSAGE(UINT32_C(1) << fault, status.first_fault, cam_fault_name(fault));
    TEST_ASSERT_EQUAL_UINT32(1, status.fault_count[fault]);
}

/// Bring the spindle to a speed without a jump, 0.13 s from 2500 r/min to 0.
static void turn_at(double rpm)
{
    rig.lathe.is_spindle_held = true;
    while (fabs(rpm - rig.lathe.rpm) > 1.0 && fixture_rig_state() != cam_state_fault) {
        rig.lathe.rpm += rpm > rig.lathe.rpm ? 1.0 : -1.0;
        fixture_rig_tick(&rig);
    }
    rig.lathe.rpm = rpm;
}

static void come_late(void)
{
    hal_host_fault_late(51);
}

static void jump(void)
{
    hal_host_fault_counts(10);
}

static void lose_a_count(void)
{
    hal_host_fault_counts(-1);
}

static void lose_the_index(void)
{
    hal_host_fault_index_dead(true);
}

static void stand(void)
{
    turn_at(0.0);
}

static void race(void)
{
    turn_at(3020.0); // highest 3000 and one percent
    fixture_rig_ticks(&rig, 200);
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, fixture_rig_state());
    turn_at(3040.0);
}

static void push_u(void)
{
    rig.lathe.error_nm[hal_axis_u] = -100010;
}

static void push_z(void)
{
    rig.lathe.is_held[hal_axis_z] = true;
    hal_host.in.axis_nm[hal_axis_z] += 150000;
}

static void test_guard_ends_the_work_for_what_goes_wrong_outside(void)
{
    static const struct {
        cam_state_t state;
        void (*cause)(void);
        cam_fault_t fault;
        uint32_t ticks; ///< a turn is 480, from plan to plan 8
    } cases[] = {
        {cam_state_cutting, come_late, cam_fault_late_tick, 1},
        {cam_state_cutting, jump, cam_fault_encoder_jump, 1},
        {cam_state_cutting, lose_a_count, cam_fault_lost_counts, 480},
        {cam_state_cutting, lose_the_index, cam_fault_index_missing, 541},
        {cam_state_cutting, stand, cam_fault_spindle_stopped, 2000 + 400},
        {cam_state_homing, stand, cam_fault_spindle_stopped, 200000 + 1000},
        {cam_state_cutting, race, cam_fault_overspeed, 200},
        {cam_state_ready, push_u, cam_fault_following_error, 1},
        {cam_state_cutting, push_z, cam_fault_z_range, 9},
    };
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        setUp();
        bring(cases[i].state);
        cases[i].cause();
        expect_within(cases[i].fault, cases[i].ticks);
    }
}

/// In ready the spindle may stand: its time counts from the start of the work on.
static void test_guard_time_of_standing_counts_in_the_work_only(void)
{
    bring(cam_state_ready);
    turn_at(0.0);
    fixture_rig_ticks(&rig, 4000);
    TEST_ASSERT_EQUAL_INT(cam_state_ready, fixture_rig_state());
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&rig.machine));
    fixture_rig_ticks(&rig, 1980);
    TEST_ASSERT_EQUAL_INT(cam_state_engaging, fixture_rig_state());
    expect_within(cam_fault_spindle_stopped, 60);
}

/// A spindle that turns against the cut ends the work as soon as it has begun.
static void test_guard_ends_a_cut_of_a_spindle_that_turns_back(void)
{
    bring(cam_state_ready);
    turn_at(-20.0);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&rig.machine));
    expect_within(cam_fault_reverse, 200);
}

/// A fault in the first enabled tick finds U at rest, whatever U did before the last fault.
static void test_guard_off_forgets_the_motion_before_it(void)
{
    const cam_config_t *config = g_cam.config.offered;
    cam_guard_t guard = {.u_set_q6 = 64, .u_step_q6 = 6400, .u_acc_q10 = 1024};
    cam_motion_t motion = {.state = cam_state_off};
    cam_tick_record_t r = {.in.inputs = hal_in_drive_ready, .want.state = cam_state_off};
    cam_guard_step_isr(&guard, &config->guard, &r, &motion);
    r.want = (cam_want_t){.state = cam_state_manual, .faults = CAM_FAULT_BIT(late_tick)};
    motion.state = cam_state_manual;
    cam_guard_step_isr(&guard, &config->guard, &r, &motion);
    TEST_ASSERT_EQUAL_INT(cam_state_fault, r.want.state);
    TEST_ASSERT_EQUAL_INT32(0, r.want.u_set_q6);
    TEST_ASSERT_EQUAL_INT32(0, motion.axis[hal_axis_u].vel_q10);
    TEST_ASSERT_EQUAL_INT32(0, motion.axis[hal_axis_u].acc_q10);
}
