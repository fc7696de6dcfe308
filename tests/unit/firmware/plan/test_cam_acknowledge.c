// SPDX-License-Identifier: Apache-2.0
// What a press of the button at the machine is good for, judged by the whole controller: the test
// knows only the input, the request of the slow side, and whether the drives come on.
#include "acknowledge_bench.h"
#include "cam_acknowledge.h"
#include "fixture_random.h" // fixture_rarer
#include <string.h>         // memcpy

void setUp(void)
{
    begin(20000);
}

static void test_power_on_wants_a_press(void)
{
    expect_refused();
    press();
    expect_enabled();
}

static void test_manual_wants_a_press_and_takes_it(void)
{
    expect_refused();
    press();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_manual(&f.machine));
    fixture_rig_ticks(&f, 2);
    TEST_ASSERT_EQUAL_INT(cam_state_manual, state());
}

static void test_without_a_stop_between_one_press_serves_for_more(void)
{
    begin_slowly();
    press();
    for (int i = 0; i < 3; i++) {
        expect_enabled();
        fixture_rig_ticks(&f, ms(70000)); // of the drives being on
        disable();
        fixture_rig_ticks(&f, ms(59800));
    }
    expect_enabled();
}

/// Whoever pressed may have left long since.
static void test_drives_that_were_off_for_a_minute_want_another_press(void)
{
    begin_slowly();
    press();
    expect_enabled();
    fixture_rig_ticks(&f, 8); // to the next plan
    disable();
    fixture_rig_ticks(&f, ms(60000));
    expect_refused();
    press();
    expect_enabled();
}

static void test_a_press_is_good_for_a_minute(void)
{
    static cam_t cam;
    static fixture_rig_t rig;
    static hal_host_t host;
    if (fixture_rarer != 1) { // a million ticks are the host's to try
        begin_slowly();
    }
    press();
    fixture_rig_ticks(&f, ms(59800));
    memcpy(&cam, &g_cam, sizeof cam);
    memcpy(&rig, &f, sizeof rig);
    memcpy(&host, &hal_host, sizeof host);
    expect_enabled();
    memcpy(&g_cam, &cam, sizeof cam);
    memcpy(&f, &rig, sizeof rig);
    memcpy(&hal_host, &host, sizeof host);
    fixture_rig_ticks(&f, ms(200));
    expect_refused();
}

static void reset(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_reset(&f.machine));
    fixture_rig_ticks(&f, ms(100));
    TEST_ASSERT_EQUAL_INT(cam_state_off, state());
}

static void test_an_emergency_stop_wants_another_press_behind_the_reset(void)
{
    stop_in_ready();
    hal_host_fault_estop(false);
    press(); // before the reset
    reset();
    expect_refused();
    press();
    expect_enabled();
}

static void test_any_fault_wants_another_press(void)
{
    press();
    expect_enabled();
    (void)fixture_rig_until(&f, cam_state_ready, 60000);
    hal_host_fault_late(300);
    fixture_rig_ticks(&f, ms(200));
    TEST_ASSERT_EQUAL_INT(cam_state_fault, state());
    reset();
    expect_refused();
    press();
    expect_enabled();
}

/// However early the reset comes, and between which plans: in ready, and by hand where nothing
/// moves and the fault is over soonest.
static void test_a_fault_that_is_reset_at_once_wants_another_press_in_every_phase_of_the_plan(void)
{
    for (uint32_t at = 0; at < 16u; at++) {
        setUp();
        press();
        post(at < 8u ? cam_request_enable : cam_request_manual);
        fixture_rig_ticks(&f, ms(2000) + at);
        TEST_ASSERT_EQUAL_INT(at < 8u ? cam_state_ready : cam_state_manual, state());
        hal_host_fault_drive(true);
        fixture_rig_tick(&f);
        TEST_ASSERT_EQUAL_INT(cam_state_fault, state());
        hal_host_fault_drive(false);
        for (uint32_t i = 0; i < ms(2000) && state() == cam_state_fault; i++) {
            post(cam_request_reset);
            fixture_rig_tick(&f);
        }
        TEST_ASSERT_EQUAL_INT(cam_state_off, state());
        post(cam_request_enable); // before the next plan as well
        fixture_rig_tick(&f);
        TEST_ASSERT_EQUAL_INT(cam_state_off, state());
        TEST_ASSERT_EQUAL_UINT32(0, hal_host.out.outputs & hal_out_enable);
        expect_refused();
    }
}

/// Enable is carried out in the very tick in which something is seen that would end it at once: the
/// drives do not come on, not even for the retract.
static void test_enable_does_not_rise_in_the_tick_that_sees_what_holds_it_off(void)
{
    static const cam_request_t requests[] = {cam_request_enable, cam_request_manual};
    for (uint32_t i = 0; i < 8u; i++) {
        setUp();
        press();
        post(requests[i % 2u]);
        hal_host_fault_estop(i / 2u == 0u);
        hal_host_fault_drive(i / 2u == 1u);
        hal_host_fault_bus(i / 2u == 2u);
        if (i / 2u == 3u) {
            hal_host_fault_late(300);
        }
        for (uint32_t k = 0; k < 20u; k++) {
            fixture_rig_tick(&f);
            TEST_ASSERT_EQUAL_UINT32(0, hal_host.out.outputs & hal_out_enable);
        }
        TEST_ASSERT_EQUAL_INT(cam_state_off, state());
        hal_host_fault_estop(false);
        hal_host_fault_drive(false);
        hal_host_fault_bus(false);
    }
}

static void test_what_else_refuses_is_told_first(void)
{
    hal_host_fault_estop(true);
    fixture_rig_ticks(&f, 10);
    TEST_ASSERT_EQUAL_INT(cam_err_estop, enable());
}

static void test_a_port_without_the_button_refuses_and_says_so(void)
{
    hal_host.slow.people = (hal_operator_t){0};
    power_on();
    fixture_rig_ticks(&f, ms(100));
    TEST_ASSERT_EQUAL_INT(cam_err_acknowledge_none, enable());
    TEST_ASSERT_EQUAL_INT(cam_err_acknowledge_none, cam_machine_manual(&f.machine));
    post(cam_request_enable);
    fixture_rig_ticks(&f, 10);
    TEST_ASSERT_EQUAL_INT(cam_state_off, state());
}

/// What is left of a press never counts below 0, and without a press nothing is left.
static void test_what_is_left_ends_at_0(void)
{
    const cam_acknowledge_config_t cfg = {.good_plans = 100};
    cam_acknowledge_t a = {.phase = cam_acknowledge_given, .n_plans = 99};
    TEST_ASSERT_EQUAL_UINT32(1, cam_acknowledge_left(&a, &cfg));
    a.n_plans = 101; // while the interrupt has not ended it
    TEST_ASSERT_EQUAL_UINT32(0, cam_acknowledge_left(&a, &cfg));
    a = (cam_acknowledge_t){.phase = cam_acknowledge_needed, .n_plans = 99};
    TEST_ASSERT_EQUAL_UINT32(0, cam_acknowledge_left(&a, &cfg));
}
