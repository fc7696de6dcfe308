// SPDX-License-Identifier: Apache-2.0
// Every fault is caused on a whole controller, in the states where it is armed and where it is not.
#include "rig_bench.h"
#include <string.h>

enum { plan_ticks = 8 }; ///< from plan to plan at 20 kHz

/// The very next tick must be the fault state with this fault as the first.
static void expect_now(cam_fault_t fault)
{
    fixture_rig_tick(&rig);
    const cam_status_t status = fixture_rig_status(&rig);
    TEST_ASSERT_EQUAL_STRING("fault", cam_state_name(status.state));
    TEST_ASSERT_BITS_HIGH(UINT32_C(1) << fault, status.first_fault);
    TEST_ASSERT_EQUAL_UINT32(1, status.fault_count[fault]);
}

static void expect_within(cam_fault_t fault, uint32_t ticks)
{
    const uint32_t passed = fixture_rig_until(&rig, cam_state_fault, ticks + 1u);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(ticks, passed);
    TEST_ASSERT_BITS_HIGH(UINT32_C(1) << fault, fixture_rig_status(&rig).first_fault);
}

static void expect_none(uint32_t ticks)
{
    const cam_state_t state = fixture_rig_state();
    fixture_rig_ticks(&rig, ticks);
    TEST_ASSERT_EQUAL_HEX32(0, fixture_rig_status(&rig).faults);
    TEST_ASSERT_EQUAL_INT(state, fixture_rig_state());
}

static void test_guard_inputs_in_every_enabled_state_are_faults_at_once(void)
{
    static const cam_state_t states[] = {cam_state_homing, cam_state_ready, cam_state_engaging,
                                         cam_state_cutting, cam_state_disengaging};
    static void (*const causes[])(bool) = {hal_host_fault_estop, hal_host_fault_drive,
                                           hal_host_fault_bus};
    static const cam_fault_t faults[] = {cam_fault_estop, cam_fault_drive, cam_fault_bus};
    for (uint32_t i = 0; i < 3u * sizeof states / sizeof states[0]; i++) {
        setUp();
        bring(states[i / 3u]);
        causes[i % 3u](true);
        expect_now(faults[i % 3u]);
    }
}

static void test_guard_inputs_while_off_latch_nothing(void)
{
    hal_host_fault_estop(true);
    hal_host_fault_drive(true);
    hal_host_fault_bus(true);
    hal_host_fault_late(400);
    expect_none(100);
}

static void test_guard_late_tick_beyond_its_limit_is_a_fault(void)
{
    bring(cam_state_cutting);
    hal_host_fault_late(49);
    expect_none(100);
    hal_host_fault_late(51);
    expect_now(cam_fault_late_tick);
    TEST_ASSERT_EQUAL_UINT32(1, fixture_rig_status(&rig).n_late);
    TEST_ASSERT_EQUAL_UINT32(15100, fixture_rig_status(&rig).max_period);
}

static void test_guard_lost_counts_are_a_fault_when_synced(void)
{
    static const struct {
        int32_t counts;
        uint32_t ticks; ///< a turn at 2500 r/min is 480
        cam_fault_t fault;
    } cases[] = {{10, 1, cam_fault_encoder_jump},   {-10, 1, cam_fault_encoder_jump},
                 {201, 1, cam_fault_encoder_jump},  {-201, 1, cam_fault_encoder_jump},
                 {2601, 1, cam_fault_encoder_jump}, {5001, 1, cam_fault_encoder_jump},
                 {1, 480, cam_fault_lost_counts},   {-1, 480, cam_fault_lost_counts},
                 {5, 480, cam_fault_lost_counts},   {-5, 480, cam_fault_lost_counts}};
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        setUp();
        bring(cam_state_cutting);
        hal_host_fault_counts(cases[i].counts);
        expect_within(cases[i].fault, cases[i].ticks);
    }
    setUp();
    bring(cam_state_homing);
    hal_host_fault_counts(500);
    expect_none(1);
}

static void test_guard_index_missing_is_a_fault_within_an_eighth_turn_more(void)
{
    bring(cam_state_cutting);
    hal_host_fault_index_dead(true);
    expect_within(cam_fault_index_missing, 541);
}

static void test_guard_reverse_and_stop_in_the_cut_are_faults(void)
{
    bring(cam_state_cutting);
    rig.lathe.is_spindle_held = true;
    for (; rig.lathe.rpm > -20.0; rig.lathe.rpm -= 1.0) { // 0.13 s from 2500 r/min
        if (fixture_rig_state() == cam_state_fault) {
            break;
        }
        fixture_rig_tick(&rig);
    }
    fixture_rig_ticks(&rig, 200);
    TEST_ASSERT_BITS_HIGH(CAM_FAULT_BIT(reverse), fixture_rig_status(&rig).first_fault);
    setUp();
    bring(cam_state_cutting);
    rig.lathe.is_spindle_held = true;
    for (; rig.lathe.rpm > 0.0; rig.lathe.rpm -= 2.5) {
        fixture_rig_tick(&rig);
    }
    rig.lathe.rpm = 0.0;
    expect_within(cam_fault_spindle_stopped, 2000 + 400);
}

/// In ready the spindle may stand: its time counts from the start of the work on.
static void test_guard_time_of_standing_counts_in_the_work_only(void)
{
    bring(cam_state_ready);
    rig.lathe.is_spindle_held = true;
    for (; rig.lathe.rpm > 0.0; rig.lathe.rpm -= 2.5) {
        fixture_rig_tick(&rig);
    }
    rig.lathe.rpm = 0.0;
    expect_none(4000);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&rig.machine));
    fixture_rig_ticks(&rig, 1980);
    TEST_ASSERT_EQUAL_INT(cam_state_engaging, fixture_rig_state());
    expect_within(cam_fault_spindle_stopped, 60);
}

static void test_guard_homing_without_rotation_gives_up(void)
{
    bring(cam_state_homing);
    rig.lathe.is_spindle_held = true;
    rig.lathe.rpm = 0.0;
    fixture_rig_ticks(&rig, 199000);
    TEST_ASSERT_EQUAL_INT(cam_state_homing, fixture_rig_state());
    expect_within(cam_fault_spindle_stopped, 2000);
}

static void test_guard_overspeed_is_a_fault_above_one_percent(void)
{
    bring(cam_state_cutting);
    rig.lathe.is_spindle_held = true;
    for (; rig.lathe.rpm < 3020.0; rig.lathe.rpm += 1.0) {
        fixture_rig_tick(&rig);
    }
    expect_none(200); // highest 3000 and one percent
    for (; rig.lathe.rpm < 3040.0; rig.lathe.rpm += 1.0) {
        fixture_rig_tick(&rig);
    }
    expect_within(cam_fault_overspeed, 200);
}

static void test_guard_following_error_is_a_fault_beyond_its_limit(void)
{
    bring(cam_state_ready);
    rig.lathe.error_nm[hal_axis_u] = 99990;
    expect_none(10);
    rig.lathe.error_nm[hal_axis_u] = -100010;
    fixture_rig_tick(&rig);
    TEST_ASSERT_BITS_HIGH(CAM_FAULT_BIT(following_error), fixture_rig_status(&rig).first_fault);
    TEST_ASSERT_INT32_WITHIN(20, -100010, fixture_rig_status(&rig).following_nm);
}

static void test_guard_z_off_its_place_is_a_fault_while_in_work(void)
{
    bring(cam_state_cutting);
    rig.lathe.is_held[hal_axis_z] = true;
    hal_host.in.axis_nm[hal_axis_z] += 150000;
    expect_within(cam_fault_z_range, plan_ticks + 1);
    setUp();
    bring(cam_state_ready);
    rig.lathe.is_held[hal_axis_z] = true;
    hal_host.in.axis_nm[hal_axis_z] += 150000000;
    expect_none(10);
}

static void test_guard_damaged_table_is_a_fault_and_stays_refused(void)
{
    bring(cam_state_cutting);
    rig.image.bytes[rig.image.size - 100u] ^= 4u;
    for (int i = 0; i < 12; i++) {
        cam_machine_poll(&rig.machine);
        fixture_rig_tick(&rig);
    }
    TEST_ASSERT_BITS_HIGH(CAM_FAULT_BIT(table), fixture_rig_status(&rig).first_fault);
    fixture_rig_ticks(&rig, 3000);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_reset(&rig.machine));
    fixture_rig_ticks(&rig, 2);
    TEST_ASSERT_EQUAL_INT(cam_err_no_table, cam_machine_enable(&rig.machine));
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
