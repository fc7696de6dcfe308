// SPDX-License-Identifier: Apache-2.0
// What counts as a press of the button at the machine, judged by the whole controller: the test
// knows only the input, the request of the slow side, and whether the drives come on.
#include "cam_acknowledge.h"
#include "cam_machine_hand.h"
#include "fixture_rig.h"
#include "hal_host.h"
#include "unity.h"
#include <string.h> // memcpy

static fixture_rig_t f;
static fixture_part_t part;

/// [ticks] of a time.
static uint32_t ms(uint32_t n)
{
    return n * (hal_host.tick_hz / 1000u);
}

static void begin(uint32_t tick_hz)
{
    part = fixture_part_short();
    fixture_rig_init(&f, &part, tick_hz);
    // Again, on a machine that has the button.
    hal_host.slow.people = (hal_operator_t){.has_acknowledge = true};
    cam_machine_init(&f.machine, &g_cam, hal_tick_hz(), hal_clock_hz());
    fixture_rig_tick(&f);
    TEST_ASSERT_EQUAL_INT(cam_ok,
                          cam_machine_select_table(&f.machine, f.image.bytes, f.image.size));
    fixture_rig_ticks(&f, ms(100));
}

void setUp(void)
{
    begin(20000);
}

void tearDown(void) {}

/// Minutes pass sooner at a slower tick; test_a_press_is_good_for_a_minute has the usual one.
static void begin_slowly(void)
{
    begin(2000);
}

/// The level of the button for some time.
static void button(bool is_pressed, uint32_t ticks)
{
    hal_host_press(is_pressed);
    fixture_rig_ticks(&f, ticks);
}

static void press(void)
{
    button(true, ms(100));
    button(false, ms(100));
}

static cam_err_t enable(void)
{
    const cam_err_t err = cam_machine_enable(&f.machine);
    fixture_rig_ticks(&f, 2);
    return err;
}

static cam_state_t state(void)
{
    return fixture_rig_state();
}

static void expect_refused(void)
{
    TEST_ASSERT_EQUAL_INT(cam_err_acknowledge, enable());
    TEST_ASSERT_EQUAL_INT(cam_err_acknowledge, cam_machine_manual(&f.machine));
    TEST_ASSERT_EQUAL_INT(cam_err_acknowledge, cam_machine_home(&f.machine));
    // The interrupt refuses by itself, whatever the slow side would post.
    const cam_request_t requests[] = {cam_request_enable, cam_request_manual};
    for (int i = 0; i < 2; i++) {
        f.machine.n_requests++;
        atomic_store(&g_cam.request, f.machine.n_requests << 8 | (uint32_t)requests[i]);
        fixture_rig_ticks(&f, 10);
        TEST_ASSERT_EQUAL_INT(cam_state_off, state());
        TEST_ASSERT_EQUAL_UINT32(0, hal_host.out.outputs & hal_out_enable);
    }
}

static void expect_enabled(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, enable());
    TEST_ASSERT_EQUAL_INT(cam_state_homing, state());
}

static void disable(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_disable(&f.machine));
    fixture_rig_ticks(&f, ms(100));
    TEST_ASSERT_EQUAL_INT(cam_state_off, state());
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
    cam_machine_init(&f.machine, &g_cam, hal_tick_hz(), hal_clock_hz());
    fixture_rig_tick(&f);
    TEST_ASSERT_EQUAL_INT(cam_ok,
                          cam_machine_select_table(&f.machine, f.image.bytes, f.image.size));
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
        f.machine.n_requests++; // before the next plan as well
        atomic_store(&g_cam.request, f.machine.n_requests << 8 | (uint32_t)cam_request_enable);
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

/// Bring the machine to ready, and let the emergency stop end that.
static void stop_in_ready(void)
{
    press();
    expect_enabled();
    (void)fixture_rig_until(&f, cam_state_ready, 60000);
    TEST_ASSERT_EQUAL_INT(cam_state_ready, state());
    hal_host_fault_estop(true);
    fixture_rig_ticks(&f, ms(200));
    TEST_ASSERT_EQUAL_INT(cam_state_fault, state());
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

/// Post a request as the slow side does, but without its judgement.
static void post(cam_request_t request)
{
    f.machine.n_requests++;
    atomic_store(&g_cam.request, f.machine.n_requests << 8 | (uint32_t)request);
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
    cam_machine_init(&f.machine, &g_cam, hal_tick_hz(), hal_clock_hz());
    fixture_rig_tick(&f);
    TEST_ASSERT_EQUAL_INT(cam_ok,
                          cam_machine_select_table(&f.machine, f.image.bytes, f.image.size));
    fixture_rig_ticks(&f, ms(100));
    TEST_ASSERT_EQUAL_INT(cam_err_acknowledge_none, enable());
    TEST_ASSERT_EQUAL_INT(cam_err_acknowledge_none, cam_machine_manual(&f.machine));
    f.machine.n_requests++;
    atomic_store(&g_cam.request, f.machine.n_requests << 8 | (uint32_t)cam_request_enable);
    fixture_rig_ticks(&f, 10);
    TEST_ASSERT_EQUAL_INT(cam_state_off, state());
}

static void test_at_the_slowest_tick_the_times_are_the_same(void)
{
    fixture_rig_init(&f, &part, 500);
    hal_host.slow.people = (hal_operator_t){.has_acknowledge = true};
    cam_machine_init(&f.machine, &g_cam, hal_tick_hz(), hal_clock_hz());
    fixture_rig_tick(&f);
    TEST_ASSERT_EQUAL_INT(cam_ok,
                          cam_machine_select_table(&f.machine, f.image.bytes, f.image.size));
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

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_power_on_wants_a_press);
    RUN_TEST(test_manual_wants_a_press_and_takes_it);
    RUN_TEST(test_without_a_stop_between_one_press_serves_for_more);
    RUN_TEST(test_drives_that_were_off_for_a_minute_want_another_press);
    RUN_TEST(test_a_press_is_good_for_a_minute);
    RUN_TEST(test_a_button_that_is_stuck_does_not_count);
    RUN_TEST(test_a_press_of_nearly_two_seconds_counts);
    RUN_TEST(test_a_button_that_is_stuck_at_power_on_does_not_count);
    RUN_TEST(test_a_short_pulse_does_not_count);
    RUN_TEST(test_a_contact_that_bounces_all_the_time_does_not_count);
    RUN_TEST(test_a_press_that_bounces_at_its_ends_counts);
    RUN_TEST(test_a_press_while_the_chain_is_open_does_not_count);
    RUN_TEST(test_a_press_across_the_closing_of_the_chain_does_not_count);
    RUN_TEST(test_one_tick_of_the_open_chain_ends_a_press);
    RUN_TEST(test_one_tick_of_the_open_chain_ends_a_press_that_has_begun);
    RUN_TEST(test_an_emergency_stop_wants_another_press_behind_the_reset);
    RUN_TEST(test_a_press_across_the_reset_does_not_count);
    RUN_TEST(test_any_fault_wants_another_press);
    RUN_TEST(test_a_fault_that_is_reset_at_once_wants_another_press_in_every_phase_of_the_plan);
    RUN_TEST(test_enable_does_not_rise_in_the_tick_that_sees_what_holds_it_off);
    RUN_TEST(test_what_else_refuses_is_told_first);
    RUN_TEST(test_a_port_without_the_button_refuses_and_says_so);
    RUN_TEST(test_at_the_slowest_tick_the_times_are_the_same);
    RUN_TEST(test_what_is_left_ends_at_0);
    return UNITY_END();
}
