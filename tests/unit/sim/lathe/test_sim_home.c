// SPDX-License-Identifier: Apache-2.0
// Home switches, indices and zeros of the simulated lathe, and the firmware that homes by them.
#include "cam_machine_jog.h"
#include "hal_host.h"
#include "sim_port.h"
#include "unity.h"

static sim_port_t port;
static cam_machine_t machine;
static sim_lathe_config_t config;

void setUp(void)
{
    config = sim_lathe_defaults();
}

static void test_look_sees_the_switch_on_its_side_and_an_index_for_a_while(void)
{
    sim_home_t home;
    const sim_home_config_t c = {.switch_mm = 10.0, .side = -1.0, .pitch_mm = 5.0, .zero_mm = 1.0};
    sim_home_init(&home, &c, 12.0);
    sim_home_look(&home, 11.5, 2);
    TEST_ASSERT_FALSE(home.is_on || home.is_seen);
    sim_home_look(&home, 10.9, 2); // an index is at 11
    TEST_ASSERT_TRUE(!home.is_on && home.is_seen);
    sim_home_look(&home, 10.0, 2);
    TEST_ASSERT_TRUE(home.is_on && home.is_seen);
    sim_home_look(&home, 9.0, 2);
    TEST_ASSERT_TRUE(home.is_on && !home.is_seen);
    TEST_ASSERT_EQUAL_INT32(1000000, home.zero_nm);
}

static void test_look_without_switch_and_index_sees_nothing(void)
{
    sim_home_t home;
    const sim_home_config_t c = {.switch_mm = 0.0};
    sim_home_init(&home, &c, -5.0);
    for (int i = -5; i < 5; i++) {
        sim_home_look(&home, i, 8);
        TEST_ASSERT_FALSE(home.is_on || home.is_seen);
    }
}

static void ticks(uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        sim_port_sense(&port);
        hal_host_tick();
        sim_port_advance(&port);
    }
}

static void set(cam_param_id_t id, int32_t value)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_set_param(&machine, id, value));
    ticks(1);
}

static void home_axis(hal_axis_t axis)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_home_axis(&machine, axis));
    for (int i = 0; i < 600 && (cam_machine_status(&machine).jog.homed >> axis & 1u) == 0u; i++) {
        ticks(2000);
        cam_machine_keep_alive(&machine);
        cam_machine_jog_poll(&machine);
    }
    ticks(4000);
    TEST_ASSERT_EQUAL_INT(cam_jog_done, cam_machine_status(&machine).jog.end);
}

/// Real drives, scales that count from anywhere: the machine's numbers are the truth afterwards, X
/// and U to what the slow speed covers in a plan and the drive lags behind, and no fault comes.
static void test_lathe_is_homed_by_the_firmware(void)
{
    config.home[hal_axis_x] =
        (sim_home_config_t){.switch_mm = 60.0, .side = 1.0, .pitch_mm = 5.0, .zero_mm = 58.0};
    config.home[hal_axis_u] = (sim_home_config_t){.switch_mm = 0.3, .side = 1.0, .zero_mm = 0.1};
    sim_port_init(&port, &config, 57e6, 0.0, 1);
    cam_machine_init(&machine, &g_cam, hal_tick_hz(), hal_clock_hz());
    ticks(10);
    TEST_ASSERT_INT32_WITHIN(10, -1000000, hal_axis_read_nm_isr(hal_axis_x));
    set(cam_param_k1_ns, 743000); // the drive of U, as it is
    set(cam_param_lead_ns, 100000);
    set(cam_param_x_home, 3);
    set(cam_param_x_home_nm, 58000000); // the index behind the switch
    set(cam_param_u_home, 2);
    set(cam_param_u_home_nm, 300000);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_manual(&machine));
    ticks(20);
    home_axis(hal_axis_x);
    home_axis(hal_axis_u);
    const double x_nm = port.lathe.drive[hal_axis_x].pos_micro;
    const double u_nm = port.lathe.drive[hal_axis_u].pos_micro;
    TEST_ASSERT_DOUBLE_WITHIN(470.0, x_nm, cam_machine_position_nm(&machine, hal_axis_x));
    TEST_ASSERT_DOUBLE_WITHIN(60.0, u_nm, cam_machine_position_nm(&machine, hal_axis_u));
    TEST_ASSERT_EQUAL_HEX32(0, cam_machine_status(&machine).faults);
}
