// SPDX-License-Identifier: Apache-2.0
// A press of the button at the machine: what counts as one, and what it permits. The whole
// controller is judged by the input, the requests of the slow side, and whether the drives come on.
#include "cam_acknowledge.h"
#include "cam_machine_jog.h" // cam_machine_manual
#include "fixture_rig.h"
#include "hal_host.h"
#include "unity.h"

static fixture_rig_t f;
static fixture_part_t part;

/// [ticks] of a time.
static uint32_t ms(uint32_t n)
{
    return n * hal_host.tick_hz / 1000u;
}

static void power_on(bool has_button)
{
    hal_host.slow.people = (hal_operator_t){.has_acknowledge = has_button};
    cam_machine_init(&f.machine, &g_cam, hal_tick_hz(), hal_clock_hz());
    fixture_rig_tick(&f);
    TEST_ASSERT_EQUAL_INT(cam_ok,
                          cam_machine_select_table(&f.machine, f.image.bytes, f.image.size));
}

static void begin(uint32_t tick_hz)
{
    part = fixture_part_short();
    fixture_rig_init(&f, &part, tick_hz);
    power_on(true);
    fixture_rig_ticks(&f, ms(100));
}

void setUp(void)
{
    begin(20000);
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

/// Post a request as the slow side does, but without its checks.
static void post(cam_request_t request)
{
    f.machine.n_requests++;
    atomic_store(&g_cam.request, f.machine.n_requests << 8 | (uint32_t)request);
}

static cam_err_t enable(void)
{
    const cam_err_t err = cam_machine_enable(&f.machine);
    fixture_rig_ticks(&f, 2);
    return err;
}

static void expect_state(cam_state_t state)
{
    TEST_ASSERT_EQUAL_INT(state, fixture_rig_state());
}

static void expect_off(const char *name)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(cam_state_off, fixture_rig_state(), name);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(0, hal_host.out.outputs & hal_out_enable, name);
}

/// The slow side refuses, and the interrupt does so itself, whatever the slow side posts.
static void expect_refused(const char *name)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(cam_err_acknowledge, enable(), name);
    TEST_ASSERT_EQUAL_INT_MESSAGE(cam_err_acknowledge, cam_machine_manual(&f.machine), name);
    TEST_ASSERT_EQUAL_INT_MESSAGE(cam_err_acknowledge, cam_machine_home(&f.machine), name);
    for (int i = 0; i < 2; i++) {
        post(i == 0 ? cam_request_enable : cam_request_manual);
        fixture_rig_ticks(&f, 10);
        expect_off(name);
    }
}

static void expect_enabled(const char *name)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(cam_ok, enable(), name);
    TEST_ASSERT_EQUAL_INT_MESSAGE(cam_state_homing, fixture_rig_state(), name);
}

static void expect_refused_until_pressed(const char *name)
{
    expect_refused(name);
    press();
    expect_enabled(name);
}

static void disable(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_disable(&f.machine));
    fixture_rig_ticks(&f, ms(100));
    expect_state(cam_state_off);
}

static void reset(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_reset(&f.machine));
    fixture_rig_ticks(&f, ms(100));
    expect_state(cam_state_off);
}

/// Enable the machine, and end that by a fault.
static void stop_in_ready(bool is_estop)
{
    press();
    expect_enabled("before the fault");
    (void)fixture_rig_until(&f, cam_state_ready, 60000);
    expect_state(cam_state_ready);
    hal_host_fault_estop(is_estop);
    hal_host_fault_late(is_estop ? 0 : 300);
    fixture_rig_ticks(&f, ms(200));
    expect_state(cam_state_fault);
}

static void test_power_on_wants_a_press(void)
{
    expect_refused_until_pressed("power on");
    setUp();
    press();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_manual(&f.machine));
    fixture_rig_ticks(&f, 2);
    expect_state(cam_state_manual);
}

/// Each row is a course of the button: n times on and off.
static void test_presses_of_50_ms_to_2_s_count(void)
{
    static const struct {
        const char *name;
        bool counts;
        struct {
            int n;
            uint32_t on_ms, off_ms;
        } course[4];
    } rows[] = {
        {"nearly two seconds", true, {{1, 1990, 100}}},
        {"stuck", false, {{1, 2200, 0}}},
        {"too short for the filter", false, {{1, 19, 100}}},
        {"48 ms", false, {{1, 48, 100}}},
        {"52 ms", true, {{1, 52, 100}}},
        {"bounces all the time", false, {{200, 6, 4}, {1, 0, 100}}},
        {"bounces at its ends", true, {{5, 1, 1}, {1, 100, 1}, {4, 1, 1}, {1, 1, 100}}},
    };
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        setUp();
        for (int k = 0; k < 4; k++) {
            for (int n = 0; n < rows[i].course[k].n; n++) {
                button(true, ms(rows[i].course[k].on_ms));
                button(false, ms(rows[i].course[k].off_ms));
            }
        }
        if (rows[i].counts) {
            expect_enabled(rows[i].name);
            continue;
        }
        expect_refused(rows[i].name);
        button(false, ms(100));
        expect_refused_until_pressed(rows[i].name);
    }
}

static void test_times_are_the_same_at_every_tick_rate(void)
{
    static const struct {
        uint32_t tick_hz, plans_per_s;
    } rows[] = {{500, 500}, {20000, 2500}};
    for (uint32_t i = 0; i < 2u; i++) {
        begin(rows[i].tick_hz);
        button(true, ms(48));
        button(false, ms(100));
        TEST_ASSERT_EQUAL_INT(cam_err_acknowledge, enable());
        button(true, ms(52));
        button(false, ms(100)); // of which 20 ms settle the input
        TEST_ASSERT_UINT32_WITHIN(
            rows[i].tick_hz == 500u ? 0 : 1,
            rows[i].plans_per_s * 60u - rows[i].plans_per_s * 8u / 100u,
            cam_acknowledge_left(&g_cam.acknowledge, &g_cam.config.half[0].play.acknowledge));
        TEST_ASSERT_EQUAL_INT(cam_ok, enable());
    }
}

static void test_a_button_that_is_stuck_at_power_on_does_not_count(void)
{
    hal_host_press(true);
    power_on(true);
    fixture_rig_ticks(&f, ms(60));
    button(false, ms(100));
    expect_refused("stuck at power on");
}

static void test_a_press_while_the_chain_is_open_or_closes_does_not_count(void)
{
    for (int is_held = 0; is_held < 2; is_held++) {
        setUp();
        hal_host_fault_estop(true);
        button(true, ms(100));
        button(is_held != 0, ms(100));
        hal_host_fault_estop(false);
        button(is_held != 0, ms(100));
        button(false, ms(100));
        expect_refused(is_held != 0 ? "held while the chain closes" : "before the chain closes");
    }
}

/// Wherever between two plans: after a press, and in it.
static void test_one_tick_of_the_open_chain_ends_a_press(void)
{
    for (uint32_t i = 0; i < 16u; i++) {
        const bool is_given = i < 8u;
        setUp();
        button(true, is_given ? ms(100) : ms(50) + i % 8u);
        if (is_given) {
            button(false, ms(100) + i);
        }
        hal_host_fault_estop(true);
        fixture_rig_tick(&f);
        hal_host_fault_estop(false);
        if (is_given) {
            fixture_rig_tick(&f);
            post(cam_request_enable); // before the next plan as well
            fixture_rig_ticks(&f, 10);
            expect_off("before the next plan");
        } else {
            button(true, ms(60));
            button(false, ms(100));
        }
        expect_refused(is_given ? "after a press" : "in a press");
    }
}

static void test_a_press_across_the_reset_does_not_count(void)
{
    stop_in_ready(true);
    hal_host_fault_estop(false);
    button(true, ms(100));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_reset(&f.machine));
    button(true, ms(100));
    button(false, ms(100));
    expect_refused("across the reset");
}

static void test_every_fault_wants_another_press(void)
{
    for (int is_estop = 0; is_estop < 2; is_estop++) {
        setUp();
        stop_in_ready(is_estop != 0);
        hal_host_fault_estop(false);
        if (is_estop != 0) {
            press(); // before the reset
        }
        reset();
        expect_refused_until_pressed(is_estop != 0 ? "emergency stop" : "late tick");
    }
}

/// Time with enabled drives does not count, a minute without ends the permission. Minutes are
/// simulated at a slow tick.
static void test_a_press_is_good_for_a_minute_without_drives(void)
{
    static const struct {
        const char *name;
        bool is_used;
        uint32_t off_ms;
        bool is_good;
    } rows[] = {{"given", false, 59800, true},
                {"given, a minute", false, 60000, false},
                {"used", true, 59800, true},
                {"used, a minute", true, 60000, false}};
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        begin(2000);
        press();
        if (rows[i].is_used) {
            expect_enabled(rows[i].name);
            fixture_rig_ticks(&f, rows[i].is_good ? ms(70000) : 8); // 8: up to the next plan
            disable();
        }
        fixture_rig_ticks(&f, ms(rows[i].off_ms));
        if (rows[i].is_good) {
            expect_enabled(rows[i].name);
        } else {
            expect_refused_until_pressed(rows[i].name);
        }
    }
}

/// However early the reset comes, and between which plans: in ready, and by hand, where nothing
/// moves and the fault is over soonest.
static void test_a_fault_that_is_reset_at_once_wants_another_press_in_every_phase_of_the_plan(void)
{
    for (uint32_t at = 0; at < 16u; at++) {
        const cam_state_t state = at < 8u ? cam_state_ready : cam_state_manual;
        setUp();
        press();
        post(at < 8u ? cam_request_enable : cam_request_manual);
        (void)fixture_rig_until(&f, state, 60000);
        fixture_rig_ticks(&f, 16u + at);
        expect_state(state);
        hal_host_fault_drive(true);
        fixture_rig_tick(&f);
        expect_state(cam_state_fault);
        hal_host_fault_drive(false);
        for (uint32_t i = 0; i < ms(2000) && fixture_rig_state() == cam_state_fault; i++) {
            post(cam_request_reset);
            fixture_rig_tick(&f);
        }
        expect_off("reset");
        post(cam_request_enable); // before the next plan as well
        fixture_rig_tick(&f);
        expect_off("before the next plan");
        expect_refused("after the reset");
    }
}

/// Enable is carried out in the very tick that sees what ends it: the drives do not come on, not
/// even for the retract.
static void test_enable_does_not_rise_in_the_tick_that_sees_a_fault(void)
{
    static const char *const names[] = {"emergency stop", "drive", "bus", "late"};
    for (uint32_t i = 0; i < 8u; i++) {
        setUp();
        press();
        post(i % 2u == 0u ? cam_request_enable : cam_request_manual);
        hal_host_fault_estop(i / 2u == 0u);
        hal_host_fault_drive(i / 2u == 1u);
        hal_host_fault_bus(i / 2u == 2u);
        hal_host_fault_late(i / 2u == 3u ? 300 : 0);
        for (uint32_t k = 0; k < 20u; k++) {
            fixture_rig_tick(&f);
            TEST_ASSERT_EQUAL_UINT32_MESSAGE(0, hal_host.out.outputs & hal_out_enable,
                                             names[i / 2u]);
        }
        expect_off(names[i / 2u]);
    }
}

static void test_other_reasons_are_reported_first(void)
{
    hal_host_fault_estop(true);
    fixture_rig_ticks(&f, 10);
    TEST_ASSERT_EQUAL_INT(cam_err_estop, enable());
    hal_host_fault_estop(false);
    power_on(false);
    fixture_rig_ticks(&f, ms(100));
    TEST_ASSERT_EQUAL_INT(cam_err_acknowledge_none, enable());
    TEST_ASSERT_EQUAL_INT(cam_err_acknowledge_none, cam_machine_manual(&f.machine));
    post(cam_request_enable);
    fixture_rig_ticks(&f, 10);
    expect_off("a port without the button");
}

/// The remaining time never counts below 0, and without a press none remains.
static void test_remaining_time_ends_at_0(void)
{
    static const struct {
        cam_acknowledge_phase_t phase;
        uint32_t n_plans, left;
    } rows[] = {{cam_acknowledge_given, 99, 1},
                {cam_acknowledge_given, 101, 0}, // the interrupt has not ended it yet
                {cam_acknowledge_needed, 99, 0}};
    const cam_acknowledge_config_t cfg = {.good_plans = 100};
    for (uint32_t i = 0; i < 3u; i++) {
        const cam_acknowledge_t a = {.phase = rows[i].phase, .n_plans = rows[i].n_plans};
        TEST_ASSERT_EQUAL_UINT32(rows[i].left, cam_acknowledge_left(&a, &cfg));
    }
}

/// Every state with enabled drives uses the press up; a fault and the chain want a new one.
static void test_every_state_with_enabled_drives_uses_it_up(void)
{
    static const cam_acknowledge_config_t cfg = {.is_demanded = true, .good_plans = 100};
    static const cam_state_t used[] = {cam_state_homing, cam_state_rehearsing,
                                       cam_state_identifying, cam_state_manual, cam_state_holding};
    static cam_tick_record_t r;
    for (uint32_t i = 0; i < 7u; i++) {
        cam_acknowledge_t a = {.phase = cam_acknowledge_given};
        cam_motion_t m = {.state = i < 5u ? used[i] : cam_state_fault, .was_open = i == 6u};
        cam_acknowledge_isr(&a, &cfg, &r, &m);
        TEST_ASSERT_EQUAL_INT(i < 5u ? cam_acknowledge_used : cam_acknowledge_needed, a.phase);
        TEST_ASSERT_EQUAL(i < 5u, m.is_acknowledged);
        TEST_ASSERT_FALSE(m.was_open);
    }
}

/// The least and the longest time of a press both count, one plan less or more does not.
static void test_a_press_of_the_least_or_the_longest_time_counts(void)
{
    static const cam_acknowledge_config_t cfg = {
        .settle_plans = 2, .least_plans = 5, .most_plans = 8, .good_plans = 100};
    for (uint32_t n = 4; n <= 9u; n++) {
        cam_acknowledge_t a = {.phase = cam_acknowledge_armed};
        cam_motion_t m = {.state = cam_state_off};
        for (uint32_t i = 0; i < 20u; i++) {
            const cam_tick_record_t r = {.in.inputs = i < n ? hal_in_acknowledge : 0u};
            cam_acknowledge_isr(&a, &cfg, &r, &m);
        }
        TEST_ASSERT_EQUAL(n >= 5u && n <= 8u, m.is_acknowledged);
    }
}
