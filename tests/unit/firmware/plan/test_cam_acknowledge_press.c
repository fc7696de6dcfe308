// SPDX-License-Identifier: Apache-2.0
// What counts as a press of the button at the machine: pulses, bounces, a button that is stuck, and
// the chain of the emergency stop or a reset in the midst of it.
#include "acknowledge_bench.h"
#include "cam_acknowledge.h"

void setUp(void)
{
    begin(20000);
}

static void test_a_button_that_is_stuck_does_not_count(void)
{
    button(true, ms(2200));
    expect_refused();
    button(false, ms(100));
    expect_refused();
    press();
    expect_enabled();
}

static void test_a_press_of_nearly_two_seconds_counts(void)
{
    button(true, ms(1990));
    button(false, ms(100));
    expect_enabled();
}

static void test_a_button_that_is_stuck_at_power_on_does_not_count(void)
{
    hal_host_press(true);
    power_on();
    fixture_rig_ticks(&f, ms(60));
    button(false, ms(100));
    expect_refused();
}

static void test_a_short_pulse_does_not_count(void)
{
    button(true, ms(19)); // the filter sees nothing of it
    button(false, ms(100));
    expect_refused();
    button(true, ms(48));
    button(false, ms(100));
    expect_refused();
    button(true, ms(52));
    button(false, ms(100));
    expect_enabled();
}

static void test_a_contact_that_bounces_all_the_time_does_not_count(void)
{
    for (int i = 0; i < 200; i++) {
        button(true, ms(6));
        button(false, ms(4));
    }
    fixture_rig_ticks(&f, ms(100));
    expect_refused();
}

static void test_a_press_that_bounces_at_its_ends_counts(void)
{
    for (int i = 0; i < 5; i++) {
        button(true, ms(1));
        button(false, ms(1));
    }
    button(true, ms(100));
    for (int i = 0; i < 5; i++) {
        button(false, ms(1));
        button(true, ms(1));
    }
    button(false, ms(100));
    expect_enabled();
}

static void test_a_press_while_the_chain_is_open_does_not_count(void)
{
    hal_host_fault_estop(true);
    press();
    hal_host_fault_estop(false);
    fixture_rig_ticks(&f, ms(100));
    expect_refused();
}

static void test_a_press_across_the_closing_of_the_chain_does_not_count(void)
{
    hal_host_fault_estop(true);
    button(true, ms(100));
    hal_host_fault_estop(false);
    button(true, ms(100));
    button(false, ms(100));
    expect_refused();
}

static void test_one_tick_of_the_open_chain_ends_a_press(void)
{
    for (uint32_t at = 0; at < 8u; at++) { // wherever between two plans
        setUp();
        press();
        fixture_rig_ticks(&f, at);
        hal_host_fault_estop(true);
        fixture_rig_tick(&f);
        hal_host_fault_estop(false);
        fixture_rig_tick(&f);
        post(cam_request_enable); // before the next plan as well
        fixture_rig_ticks(&f, 10);
        TEST_ASSERT_EQUAL_INT(cam_state_off, state());
        expect_refused();
    }
}

static void test_one_tick_of_the_open_chain_ends_a_press_that_has_begun(void)
{
    for (uint32_t at = 0; at < 8u; at++) {
        setUp();
        button(true, ms(50) + at);
        hal_host_fault_estop(true);
        fixture_rig_tick(&f);
        hal_host_fault_estop(false);
        button(true, ms(60));
        button(false, ms(100));
        expect_refused();
    }
}

static void test_a_press_across_the_reset_does_not_count(void)
{
    stop_in_ready();
    hal_host_fault_estop(false);
    button(true, ms(100));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_reset(&f.machine));
    button(true, ms(100));
    button(false, ms(100));
    expect_refused();
}

static void test_at_the_slowest_tick_the_times_are_the_same(void)
{
    fixture_rig_init(&f, &part, 500);
    hal_host.slow.people = (hal_operator_t){.has_acknowledge = true};
    power_on();
    fixture_rig_ticks(&f, 50);
    button(true, 24); // 48 ms
    button(false, 50);
    TEST_ASSERT_EQUAL_INT(cam_err_acknowledge, enable());
    button(true, 26);
    button(false, 50);
    TEST_ASSERT_EQUAL_UINT32(
        30000 - 40, // plans of 2 ms, the first of which behind the settling of the input
        cam_acknowledge_left(&g_cam.acknowledge, &g_cam.config.half[0].play.acknowledge));
    TEST_ASSERT_EQUAL_INT(cam_ok, enable());
}
