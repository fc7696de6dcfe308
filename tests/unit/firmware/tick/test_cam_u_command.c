// SPDX-License-Identifier: Apache-2.0
// What the axes are told: the command of U with its feed-forward within the speed of U in every
// tick through faults at any angle, and a command beyond its limits that is a fault, not written.
#include "rig_bench.h"
#include <stdlib.h>

/// Configuration in force, which a test may spoil behind the back of all checks.
static cam_config_t *in_force(void)
{
    return &g_cam.config.half[g_cam.config.offered == &g_cam.config.half[0] ? 0 : 1];
}

/// The drive of the default machine of host_sim: 300 Hz, 0.7.
static void with_feed_forward(void)
{
    set(cam_param_k1_ns, 742723);
    set(cam_param_k2_us2, 281448);
    set(cam_param_following_limit_nm, 10000000);
}

typedef struct {
    int32_t at_nm, step_nm;
    int32_t most_step_nm, most_change_nm;
} told_t;

static void tick(told_t *t)
{
    fixture_rig_tick(&rig);
    const int32_t at_nm = hal_host.out.axis[hal_axis_u].pos_nm;
    const int32_t step_nm = at_nm - t->at_nm;
    const int32_t change_nm = abs(step_nm - t->step_nm);
    t->most_step_nm = abs(step_nm) > t->most_step_nm ? abs(step_nm) : t->most_step_nm;
    t->most_change_nm = change_nm > t->most_change_nm ? change_nm : t->most_change_nm;
    t->at_nm = at_nm;
    t->step_nm = step_nm;
}

/// Three ticks tell the step of now and its change.
static told_t begin(void)
{
    told_t t = {.at_nm = hal_host.out.axis[hal_axis_u].pos_nm};
    tick(&t);
    tick(&t);
    t.most_step_nm = t.most_change_nm = 0;
    return t;
}

/// Press the emergency stop: it must be the only fault. @return U's command of n ticks
static told_t retract(int n)
{
    told_t t = begin();
    hal_host_fault_estop(true);
    for (int i = 0; i < n; i++) {
        tick(&t);
    }
    TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(estop), fixture_rig_status(&rig).faults);
    return t;
}

static void test_command_through_faults_at_any_angle_keeps_the_speed_of_u(void)
{
    static bench_t bench;
    with_feed_forward();
    bring(cam_state_cutting);
    fixture_rig_ticks(&rig, 2400);
    keep(&bench);
    for (uint32_t at = 0; at < 240; at += 16) {
        go_back(&bench);
        fixture_rig_ticks(&rig, at);
        const told_t t = retract(200);
        TEST_ASSERT_LESS_OR_EQUAL_INT32(20000, t.most_step_nm);
        TEST_ASSERT_LESS_OR_EQUAL_INT32(in_force()->command.change_nm, t.most_change_nm);
        TEST_ASSERT_EQUAL_INT32(-500000, t.at_nm);
    }
}

/// A U without feed-forward is told its set-point, and so no more than its acceleration.
static void test_command_through_faults_at_any_angle_keeps_the_acceleration_of_u(void)
{
    static bench_t bench;
    fixture_rig_init(&rig, &part, 5000);
    set(cam_param_u_acceleration_mm_per_s2, 20000); // 800 nm per tick^2
    set(cam_param_spindle_mrpm, (int32_t)cam_machine_highest_mrpm(&rig.machine));
    bring(cam_state_cutting);
    fixture_rig_ticks(&rig, 500);
    keep(&bench);
    for (uint32_t at = 0; at < 120; at++) {
        go_back(&bench);
        fixture_rig_ticks(&rig, at);
        TEST_ASSERT_LESS_OR_EQUAL_INT32(850, retract(200).most_change_nm);
    }
}

static void begin_slowly(void)
{
    fixture_rig_init(&rig, &part, 1000);
    set(cam_param_u_speed_um_per_s, 50000);
    set(cam_param_spindle_mrpm, 100000);
    set(cam_param_following_limit_nm, 10000000);
}

/// At 1 kHz the acceleration of a tick is five times the speed of a tick.
static void test_command_at_1_khz_keeps_the_speed_of_u_in_homing_and_retract(void)
{
    begin_slowly();
    told_t t = begin();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_enable(&rig.machine));
    for (int i = 0; i < 200; i++) {
        tick(&t);
    }
    TEST_ASSERT_EQUAL_INT32(-500000, t.at_nm);
    TEST_ASSERT_LESS_OR_EQUAL_INT32(12501, t.most_step_nm); // a quarter
    TEST_ASSERT_GREATER_THAN_INT32(12000, t.most_step_nm);
    for (uint32_t k = 0; k < 40u; k++) {
        begin_slowly();
        bring(cam_state_cutting);
        fixture_rig_ticks(&rig, 37u * k);
        t = retract(100);
        TEST_ASSERT_EQUAL_INT32(-500000, t.at_nm);
        TEST_ASSERT_LESS_OR_EQUAL_INT32(50000, t.most_step_nm);
    }
}

/// A stiff drive of 900 Hz at 2 kHz: a window is two ticks, and what the feed-forward adds while
/// the acceleration of the retract ends is a tenth of the speed.
static void test_command_of_the_retract_keeps_the_speed_of_u_in_a_short_window(void)
{
    for (uint32_t at = 0; at < 20u; at++) {
        fixture_rig_init(&rig, &part, 2000);
        set(cam_param_u_speed_um_per_s, 300000);
        set(cam_param_u_acceleration_mm_per_s2, 2000000);
        set(cam_param_k1_ns, 282942);
        set(cam_param_k2_us2, 31270);
        set(cam_param_spindle_mrpm, 100000);
        set(cam_param_following_limit_nm, 10000000);
        bring(cam_state_cutting);
        fixture_rig_ticks(&rig, 37u * at);
        TEST_ASSERT_LESS_OR_EQUAL_INT32(150000, retract(200).most_step_nm);
    }
}

/// The stroke ends where U retracts to. Gains of slow drives and of fast ones, with and without an
/// acceleration that is told ahead.
static void test_command_stays_within_the_stroke_in_homing_and_retract(void)
{
    static const int32_t gains[][2] = {{350000, 0},     {398000, 0},     {200000, 0},
                                       {350000, 40000}, {742723, 0},     {742723, 281448},
                                       {1500000, 0},    {300000, 22500}, {100000, 0}};
    static const uint32_t rates_hz[] = {20000, 5000, 2000};
    for (int i = 0; i < 27; i++) {
        const uint32_t hz = rates_hz[i / 9];
        fixture_rig_init(&rig, &part, hz);
        set(cam_param_u_stroke_nm, 900000);
        set(cam_param_k1_ns, gains[i % 9][0]);
        set(cam_param_k2_us2, gains[i % 9][1]);
        set(cam_param_spindle_mrpm, 200000);
        set(cam_param_following_limit_nm, 10000000);
        bring(cam_state_engaging);
        fixture_rig_ticks(&rig, hz / 10);
        TEST_ASSERT_EQUAL_INT32(0, rig.last.want.u_set_q6);
        hal_host_fault_estop(true);
        fixture_rig_ticks(&rig, hz / 10);
        TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(estop), fixture_rig_status(&rig).faults);
    }
}

/// The tick of the fault tells the acceleration with which its set-point goes on.
static void test_fault_tick_tells_the_acceleration_of_its_set_points(void)
{
    for (uint32_t at = 0; at < 120; at += 20) {
        setUp();
        bring(cam_state_cutting);
        fixture_rig_ticks(&rig, 2400 + at);
        const double a = rig.last.want.u_set_q6 / 64.0;
        fixture_rig_tick(&rig);
        const double b = rig.last.want.u_set_q6 / 64.0;
        hal_host_fault_estop(true);
        fixture_rig_tick(&rig);
        const double c = rig.last.want.u_set_q6 / 64.0;
        const hal_setpoint_t *told = &hal_host.out.axis[hal_axis_u];
        TEST_ASSERT_EQUAL_INT(cam_state_fault, rig.last.want.state);
        TEST_ASSERT_DOUBLE_WITHIN(0.1, c - 2.0 * b + a, told->acc_q10 / 1024.0);
        TEST_ASSERT_DOUBLE_WITHIN(0.1, c - b, told->vel_q10 / 1024.0);
    }
}

/// While off an axis is found half a millimetre from where the cut begins.
static void move_from_its_begin(hal_axis_t axis)
{
    hal_host.in.axis_nm[axis] += 500000;
    fixture_rig_ticks(&rig, 20);
}

/// From plan to plan X and Z move in equal increments: no acceleration is told, and there is none.
static void test_x_and_z_are_told_the_acceleration_of_their_increments(void)
{
    move_from_its_begin(hal_axis_x);
    move_from_its_begin(hal_axis_z);
    bring(cam_state_engaging);
    bool has_moved[hal_n_axes] = {false};
    for (int i = 0; i < 80000 && rig.last.want.state != cam_state_disengaging; i++) {
        const hal_setpoint_t before[hal_n_axes] = {[hal_axis_x] = hal_host.out.axis[hal_axis_x],
                                                   [hal_axis_z] = hal_host.out.axis[hal_axis_z]};
        fixture_rig_tick(&rig);
        for (uint32_t k = (uint32_t)hal_axis_x; k <= (uint32_t)hal_axis_z; k++) {
            const hal_setpoint_t *now = &hal_host.out.axis[k];
            has_moved[k] = has_moved[k] || now->vel_q10 != 0;
            TEST_ASSERT_EQUAL_INT32(0, now->acc_q10);
            if (now->vel_q10 == before[k].vel_q10) {
                TEST_ASSERT_DOUBLE_WITHIN(1.1, now->vel_q10 / 1024.0,
                                          (double)now->pos_nm - before[k].pos_nm);
            }
        }
    }
    TEST_ASSERT_TRUE(has_moved[hal_axis_x] && has_moved[hal_axis_z]);
}

/// A gain that spoilt the configuration in force, in homing and in the cut.
static void test_command_of_a_wrong_gain_is_a_fault_and_not_written(void)
{
    for (int i = 0; i < 2; i++) {
        setUp();
        with_feed_forward();
        bring(i == 0 ? cam_state_off : cam_state_cutting);
        fixture_rig_ticks(&rig, 200);
        told_t t = begin();
        if (i == 0) {
            TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_enable(&rig.machine));
        }
        in_force()->command.by_time.k2_q16 *= 48;
        in_force()->command.in_cut.k2_q16 *= 48;
        for (int k = 0; k < 4000; k++) {
            tick(&t);
        }
        TEST_ASSERT_EQUAL_INT(cam_state_fault, fixture_rig_state());
        TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(command), fixture_rig_status(&rig).first_fault);
        TEST_ASSERT_LESS_OR_EQUAL_INT32(in_force()->command.step_nm, t.most_step_nm);
        TEST_ASSERT_TRUE(fixture_rig_status(&rig).is_retracted);
        TEST_ASSERT_EQUAL_INT32(-500000, t.at_nm);
        TEST_ASSERT_EQUAL_INT32(0, t.step_nm);
    }
}

/// A plan that would tell X or Z too much is not carried out: the axis goes on as before.
static void test_increments_beyond_the_limits_are_a_fault_before_they_are_told(void)
{
    for (uint32_t i = (uint32_t)hal_axis_x; i <= (uint32_t)hal_axis_z; i++) {
        setUp();
        move_from_its_begin((hal_axis_t)i);
        bring(i == (uint32_t)hal_axis_x ? cam_state_engaging : cam_state_cutting);
        for (int k = 0; k < 20000 && hal_host.out.axis[i].vel_q10 == 0; k++) {
            fixture_rig_tick(&rig);
        }
        const int32_t vel_q10 = hal_host.out.axis[i].vel_q10;
        TEST_ASSERT_NOT_EQUAL_INT32(0, vel_q10);
        in_force()->command.vel_q10[i] = 0; // the axis moves, and may not
        uint32_t n = 0;
        while (rig.last.want.state != cam_state_fault && n < 20) {
            TEST_ASSERT_INT32_WITHIN(8000, vel_q10, hal_host.out.axis[i].vel_q10);
            fixture_rig_tick(&rig);
            n++;
        }
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(10, n);
        TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(command), fixture_rig_status(&rig).first_fault);
    }
}

/// X leaves a clearance of 5 mm in a turn: a count of the encoder moves it by 0.94 um.
static void test_steps_of_the_encoder_move_x_off_a_wide_clearance_without_a_fault(void)
{
    fixture_rig_init(&rig, &part, 5000);
    set(cam_param_engage_turns, 1);
    set(cam_param_x_clearance_nm, 5000000);
    set(cam_param_spindle_mrpm, 470700); // no whole number of counts per tick
    set(cam_param_observer_bandwidth_mHz, 400000);
    set(cam_param_following_limit_nm, 10000000);
    bring(cam_state_cutting);
}

/// A fast observer makes a speed of every count, and the lag of X multiplies it.
static void test_fast_observer_moves_x_off_a_wide_clearance_without_a_fault(void)
{
    set(cam_param_x_clearance_nm, 20000000);
    set(cam_param_engage_turns, 10);
    set(cam_param_xz_lag_ns, 6366198);
    set(cam_param_spindle_mrpm, 1507300);
    set(cam_param_observer_bandwidth_mHz, 1000000);
    set(cam_param_following_limit_nm, 10000000);
    bring(cam_state_ready);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&rig.machine));
    TEST_ASSERT_LESS_THAN_UINT32(200000, fixture_rig_until(&rig, cam_state_cutting, 200000));
}
