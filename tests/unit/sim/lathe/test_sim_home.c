// SPDX-License-Identifier: Apache-2.0
// Home switches, indices, zeros and stops of the simulated lathe, and the firmware that homes by
// them.
#include "cam_machine_inner.h"
#include "hal_host.h"
#include "sim_config.h"
#include "sim_port.h"
#include "unity.h"
#include <math.h>   // fabs, fmax
#include <stddef.h> // NULL
#include <stdlib.h> // labs

enum { force_mn = 20000, quantum_mn = 20 };

static sim_port_t port;
static cam_machine_t machine;
static sim_lathe_config_t config;
static cam_params_t params;
static int32_t most_q6; ///< largest force written
static double most_mm;  ///< U was farthest from 0 there

static void derive(void)
{
    common_error_t e;
    static const sim_wishes_t none;
    TEST_ASSERT_TRUE(sim_controller_params(&params, &config, false, &none, &e));
}

/// A U that takes forces, between two stops, homed by one of them.
void setUp(void)
{
    config = sim_config_defaults().lathe;
    sim_drive_config_t *u = &config.drive[hal_axis_u];
    u->kind = sim_drive_force;
    u->delay_us = 25.0;
    u->friction_m_per_s2 = 3.0;
    u->stop_units = 0.65;
    derive();
    params.u_home = 4;
    params.u_home_nm = 650000;
    params.u_home_force_mn = force_mn;
}

static void test_look_sees_the_switch_on_its_side_and_an_index_for_a_while(void)
{
    static const struct {
        double mm;
        bool is_on, is_seen;
    } looks[] = {{11.5, false, false},
                 {10.9, false, true}, // an index is at 11
                 {10.0, true, true},
                 {9.0, true, false}};
    const sim_home_config_t both = {
        .switch_mm = 10.0, .side = -1.0, .pitch_mm = 5.0, .zero_mm = 1.0};
    const sim_home_config_t neither = {.switch_mm = 10.0};
    sim_home_t home;
    sim_home_t nothing;
    sim_home_init(&home, &both, 12.0);
    sim_home_init(&nothing, &neither, 12.0);
    for (int i = 0; i < 4; i++) {
        sim_home_look(&home, looks[i].mm, 2);
        TEST_ASSERT_EQUAL(looks[i].is_on, home.is_on);
        TEST_ASSERT_EQUAL(looks[i].is_seen, home.is_seen);
        sim_home_look(&nothing, looks[i].mm, 2);
        TEST_ASSERT_FALSE(nothing.is_on || nothing.is_seen);
    }
    TEST_ASSERT_EQUAL_INT32(1000000, home.zero_nm);
}

static void ticks(uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        sim_port_sense(&port);
        hal_host_tick();
        sim_port_advance(&port);
        const double u_mm = port.lathe.drive[hal_axis_u].pos_micro * 1e-6;
        most_mm = fmax(most_mm, fabs(u_mm));
        const int32_t q6 = (int32_t)labs(hal_host.out.force_q6);
        most_q6 = q6 > most_q6 ? q6 : most_q6;
    }
}

static void begin(double start_mm)
{
    hal_host_reset((uint32_t)config.tick_hz);
    sim_port_init(&port, &config, 57e6, 0.0, 1);
    port.lathe.drive[hal_axis_u].pos_micro = start_mm * 1e6;
    port.home[hal_axis_u].zero_nm += (int32_t)(start_mm * 1e6); // the scale begins to count here
    cam_machine_init(&machine, &g_cam, hal_tick_hz(), hal_clock_hz());
    ticks(10);
    cam_machine_stage_begin(&machine);
    for (cam_param_id_t id = 0; id < cam_n_params; id++) {
        const int32_t value = cam_param_get(&params, id);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stage(&machine, id, value));
    }
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stage_commit(&machine));
    ticks(10);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_manual(&machine));
    ticks(100);
    most_q6 = 0;
    most_mm = 0.0;
}

static void expect_homed(uint32_t axes)
{
    TEST_ASSERT_EQUAL_HEX32(axes, cam_machine_status(&machine).jog.homed);
    TEST_ASSERT_EQUAL_HEX32(0, cam_machine_status(&machine).faults);
}

/// No force beyond that of homing was written.
static void expect_limited(int32_t most_mn)
{
    TEST_ASSERT_LESS_OR_EQUAL_INT32((most_mn + quantum_mn) * 64, most_q6);
}

static void home(hal_axis_t axis, cam_jog_end_t end)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(&machine, axis));
    ticks(20);
    for (int i = 0; i < 4000 && cam_machine_status(&machine).jog.phase != cam_jog_rest; i++) {
        ticks(1000);
        cam_machine_keep_alive(&machine);
        cam_machine_jog_poll(&machine);
    }
    ticks(4000);
    TEST_ASSERT_EQUAL_INT(end, cam_machine_status(&machine).jog.end);
}

/// @return [nm] where U is, minus where the controller reads it
static double off_nm(void)
{
    return port.lathe.drive[hal_axis_u].pos_micro - cam_machine_status(&machine).u_actual_nm;
}

/// From anywhere, on the stop too, and three times in a row: the stop, which 20 N compress by 2 um,
/// has the position that was set. U then holds against a push of more than the limit.
static void test_home_is_the_same_from_anywhere(void)
{
    static const double starts_mm[] = {0.0, 0.6505, -0.4};
    for (int i = 0; i < 3; i++) {
        setUp();
        begin(starts_mm[i]);
        double first_nm = 0.0;
        for (int k = 0; k < 3; k++) {
            home(hal_axis_u, cam_jog_done);
            expect_homed(1u << hal_axis_u);
            first_nm = k == 0 ? off_nm() : first_nm;
            TEST_ASSERT_DOUBLE_WITHIN(1000.0, 2000.0, off_nm());
            TEST_ASSERT_DOUBLE_WITHIN(2000.0, first_nm, off_nm());
        }
        expect_limited(force_mn);
        TEST_ASSERT_TRUE(most_mm < 0.655);
        const double rests_nm = port.lathe.drive[hal_axis_u].pos_micro;
        sim_drive_disturb(&port.lathe.drive[hal_axis_u], -40.0);
        ticks(8000);
        TEST_ASSERT_DOUBLE_WITHIN(200.0, rests_nm, port.lathe.drive[hal_axis_u].pos_micro);
        TEST_ASSERT_GREATER_THAN_INT32(force_mn * 64, most_q6);
    }
}

/// Set the loop of the first power-up, whose set-point leads by far.
static void weaken(void)
{
    params.servo_crossover_hz = 30;
    params.servo_lead_percent = 2000;
    params.servo_pole_hz = 1000;
    params.servo_integral_mHz = 3000;
    params.servo_runaway_nm = 5000;
    params.servo_force_limit_mn = 20000;
    params.u_acceleration_mm_per_s2 = 5000;
    params.u_speed_um_per_s = 5000;
    params.u_home_force_mn = 10000;
}

/// The other stop; a weak loop; a hot motor, which has no more than its continuous force.
static void test_stop_is_found_by_either_sense_and_a_weak_loop(void)
{
    static const struct {
        int32_t sense;
        bool is_weak;
        int32_t continuous_mn;
        double off_nm, within_nm;
        int32_t most_mn;
    } cases[] = {{-1, false, 0, -2000.0, 1000.0, force_mn},
                 {1, true, 20000, 1000.0, 1000.0, 10000},
                 {1, true, 8000, 0.0, 1e6, 8000}};
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        setUp();
        params.u_home_sense = cases[i].sense;
        params.u_home_nm *= cases[i].sense;
        if (cases[i].is_weak) {
            weaken();
            params.servo_continuous_mn = cases[i].continuous_mn;
        }
        begin(0.2);
        home(hal_axis_u, cam_jog_done);
        expect_homed(1u << hal_axis_u);
        TEST_ASSERT_DOUBLE_WITHIN(cases[i].within_nm, cases[i].off_nm, off_nm());
        expect_limited(cases[i].most_mn);
    }
}

/// Real drives, scales that count from anywhere: the machine's numbers are the truth afterwards, X
/// and U to what the slow speed covers in a plan and the drive lags behind, and no fault comes.
static void test_lathe_is_homed_by_its_switches(void)
{
    config = sim_config_defaults().lathe;
    config.home[hal_axis_x] =
        (sim_home_config_t){.switch_mm = 60.0, .side = 1.0, .pitch_mm = 5.0, .zero_mm = 58.0};
    config.home[hal_axis_u] = (sim_home_config_t){.switch_mm = 0.3, .side = 1.0, .zero_mm = 0.1};
    derive();
    params.x_home = 3;
    params.x_home_nm = 58000000; // the index behind the switch
    params.u_home = 2;
    params.u_home_nm = 300000;
    begin(0.0);
    TEST_ASSERT_INT32_WITHIN(10, -1000000, hal_axis_read_nm_isr(hal_axis_x));
    home(hal_axis_x, cam_jog_done);
    home(hal_axis_u, cam_jog_done);
    expect_homed(1u << hal_axis_x | 1u << hal_axis_u);
    const double x_nm = port.lathe.drive[hal_axis_x].pos_micro;
    const double u_nm = port.lathe.drive[hal_axis_u].pos_micro;
    TEST_ASSERT_DOUBLE_WITHIN(470.0, x_nm, cam_machine_position_nm(&machine, hal_axis_x));
    TEST_ASSERT_DOUBLE_WITHIN(60.0, u_nm, cam_machine_position_nm(&machine, hal_axis_u));
}

/// A scale that freezes while U comes back from its stop: homing finds no home, and U presses on
/// the other stop with the force of homing. Or it freezes just before the end: then the fault comes
/// within half a millisecond of the full force, which has risen to five times that.
static void test_scale_that_freezes_on_the_way_back_gives_no_home(void)
{
    for (int32_t back_um = 4; back_um <= 49; back_um += 9) {
        setUp();
        begin(0.2);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(&machine, hal_axis_u));
        double stop_nm = 0.0;
        for (int i = 0; i < 200000; i++) {
            ticks(1);
            if (i % 1000 == 0) {
                cam_machine_keep_alive(&machine);
                cam_machine_jog_poll(&machine);
            }
            const double at_nm = port.lathe.drive[hal_axis_u].pos_micro;
            const bool is_back = cam_machine_status(&machine).jog.phase == cam_jog_release;
            stop_nm = is_back ? stop_nm : at_nm;
            if (is_back && !port.lathe.is_scale_stuck && stop_nm - at_nm > back_um * 1e3) {
                port.lathe.stuck_micro = (int32_t)at_nm;
                port.lathe.is_scale_stuck = true;
            }
        }
        const cam_status_t s = cam_machine_status(&machine);
        const bool is_found = s.faults == CAM_FAULT_BIT(u_runaway);
        TEST_ASSERT_TRUE(port.lathe.is_scale_stuck);
        TEST_ASSERT_TRUE(is_found || s.jog.end == cam_jog_no_release);
        TEST_ASSERT_EQUAL_HEX32(0, s.jog.homed);
        expect_limited(is_found ? 5 * force_mn : force_mn);
    }
}
