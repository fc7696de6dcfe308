// SPDX-License-Identifier: Apache-2.0
// A press of the button at the machine: which presses count, plan by plan, and what they permit on
// a whole controller, judged by the requests of the slow side and by whether the drives come on.
#define OWN_SET_UP
#include "cam_plan.h"
#include "cam_machine.h" // cam_machine_manual
#include "rig_bench.h"

/// [ticks] of a time.
static uint32_t ms(uint32_t n)
{
    return n * hal_host.tick_hz / 1000u;
}

static void power_on(bool has_button)
{
    hal_host.slow.people = (hal_operator_t){.has_acknowledge = has_button};
    cam_machine_init(&rig.machine, &g_cam, hal_tick_hz(), hal_clock_hz());
    fixture_rig_tick(&rig);
    TEST_ASSERT_EQUAL_INT(cam_ok,
                          cam_machine_select_table(&rig.machine, rig.image.bytes, rig.image.size));
}

static void begin(uint32_t tick_hz)
{
    part = fixture_part_short();
    fixture_rig_init(&rig, &part, tick_hz);
    power_on(true);
    fixture_rig_ticks(&rig, ms(100));
}

void setUp(void)
{
    begin(20000);
}

/// The level of the button for some time.
static void button(bool is_pressed, uint32_t ticks)
{
    hal_host_press(is_pressed);
    fixture_rig_ticks(&rig, ticks);
}

static void press(void)
{
    button(true, ms(100));
    button(false, ms(100));
}

/// Post a request as the slow side does, but without its checks.
static void post(cam_request_t request)
{
    rig.machine.n_requests++;
    atomic_store(&g_cam.request, rig.machine.n_requests << 8 | (uint32_t)request);
}

static cam_err_t enable(void)
{
    const cam_err_t err = cam_machine_enable(&rig.machine);
    fixture_rig_ticks(&rig, 2);
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
    TEST_ASSERT_EQUAL_INT_MESSAGE(cam_err_acknowledge, cam_machine_manual(&rig.machine), name);
    TEST_ASSERT_EQUAL_INT_MESSAGE(cam_err_acknowledge, cam_machine_home(&rig.machine), name);
    for (int i = 0; i < 2; i++) {
        post(i == 0 ? cam_request_enable : cam_request_manual);
        fixture_rig_ticks(&rig, 10);
        expect_off(name);
    }
}

static void test_power_on_wants_a_press_of_50_ms(void)
{
    button(true, ms(48));
    button(false, ms(100));
    expect_refused("power on");
    press();
    TEST_ASSERT_EQUAL_INT(cam_ok, enable());
    expect_state(cam_state_homing);
    setUp();
    press();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_manual(&rig.machine));
    fixture_rig_ticks(&rig, 2);
    expect_state(cam_state_manual);
}

static void test_times_are_the_same_at_every_tick_rate(void)
{
    static const struct {
        uint32_t tick_hz;
        cam_acknowledge_config_t plans; ///< of 20 ms, 50 ms, 2 s and a minute, rounded up
    } rows[] = {{500, {true, 10, 25, 1000, 30000}},
                {1000, {true, 20, 50, 2000, 60000}},
                {3750, {true, 38, 94, 3750, 112500}},
                {20000, {true, 50, 125, 5000, 150000}}};
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        begin(rows[i].tick_hz);
        const cam_acknowledge_config_t *found = &g_cam.config.offered->play.acknowledge;
        TEST_ASSERT_EQUAL(rows[i].plans.is_demanded, found->is_demanded);
        TEST_ASSERT_EQUAL_UINT32(rows[i].plans.settle_plans, found->settle_plans);
        TEST_ASSERT_EQUAL_UINT32(rows[i].plans.least_plans, found->least_plans);
        TEST_ASSERT_EQUAL_UINT32(rows[i].plans.most_plans, found->most_plans);
        TEST_ASSERT_EQUAL_UINT32(rows[i].plans.good_plans, found->good_plans);
    }
}

/// A plan of a course: '.' released, 'P' pressed, 'E' chain open, 'X' both, 'w' chain was open
/// since the last plan; in state fault 'F' released, 'f' pressed; 'H' released with enabled drives.
static void plan(char what, cam_state_t enabled, cam_acknowledge_t *a, cam_motion_t *m)
{
    static const cam_acknowledge_config_t cfg = {
        .settle_plans = 2, .least_plans = 5, .most_plans = 8, .good_plans = 10};
    const bool is_pressed = strchr("PXf", what) != NULL;
    const bool is_open = strchr("EX", what) != NULL;
    const cam_tick_record_t r = {.in.inputs = (is_pressed ? hal_in_acknowledge : 0u) |
                                              (is_open ? hal_in_estop : 0u)};
    m->was_open = what == 'w';
    m->state = strchr("Ff", what) != NULL ? cam_state_fault : what == 'H' ? enabled : cam_state_off;
    cam_acknowledge_isr(a, &cfg, &r, m);
    TEST_ASSERT_FALSE(m->was_open);
    const bool is_given = a->phase == cam_acknowledge_given;
    TEST_ASSERT_EQUAL_UINT32(is_given ? cfg.good_plans - a->n_plans : 0u,
                             cam_acknowledge_left(a, &cfg));
}

/// A press counts if it lasts 5 to 8 plans, after 5 without; it is good for 10 plans without
/// drives.
static void test_which_presses_count(void)
{
    static const struct {
        const char *name, *course; ///< from power on
        bool counts;
    } rows[] = {
        {"none", "................", false},
        {"too short", ".......PPPP.......", false},
        {"shortest", ".......PPPPP..", true},
        {"longest", ".......PPPPPPPP..", true},
        {"too long", ".......PPPPPPPPP.......", false},
        {"stuck", ".......PPPPPPPPPPPPPPPP", false},
        {"pressed at power on", "PPPPPP.......", false},
        {"soon after another press", "PPPP....PPPPPP..", false},
        {"not so soon after another press", "PPPP.....PPPPPP..", true},
        {"soon after one that was too short", ".......PPPP...PPPPP..", false},
        {"another press after one that was too short", ".......PPPP.........PPPPP..", true},
        {"bounces all the time", ".......P.P.P.P.P.P.P......", false},
        {"bounces at its ends", ".......P.PPPPPP.P..", true},
        {"before the chain closes", ".......EEXXXXXEE..", false},
        {"held while the chain closes", ".......XXXXPPPPP..", false},
        {"chain opens in the press", ".......PPXPPPPP..", false},
        {"chain opens after the press", ".......PPPPP..E..", false},
        {"chain was open between two plans", ".......PPPPP..w", false},
        {"fault after the press", ".......PPPPP..F..", false},
        {"in the state fault", ".......fffffFF..", false},
        {"across the reset", ".......fffPPPPP..", false},
        {"fault while it is used", ".......PPPPP..HHF..", false},
        {"another press after the fault", ".......PPPPP..HHF......PPPPP..", true},
        {"just in time", ".......PPPPP...........", true},
        {"too late", ".......PPPPP............", false},
        {"in use", ".......PPPPP..HHHHHHHHHHHHHHHH", true},
        {"just in time after use", ".......PPPPP..HHHHHHHHHHHHHH..........", true},
        {"too late after use", ".......PPPPP..HHHHHHHHHHHHHH...........", false},
    };
    const uint32_t n_rows = sizeof rows / sizeof rows[0];
    for (uint32_t i = 0; i < n_rows * cam_n_states; i++) {
        const cam_state_t enabled = (cam_state_t)(i / n_rows);
        if (enabled == cam_state_off || enabled == cam_state_fault) {
            continue;
        }
        cam_acknowledge_t a = {0};
        cam_motion_t m = {0};
        for (const char *what = rows[i % n_rows].course; *what != '\0'; what++) {
            plan(*what, enabled, &a, &m);
        }
        TEST_ASSERT_EQUAL_MESSAGE(rows[i % n_rows].counts, m.is_acknowledged,
                                  rows[i % n_rows].name);
    }
}

/// Wherever between two plans.
static void test_one_tick_of_the_open_chain_ends_a_press(void)
{
    for (uint32_t i = 0; i < 8u; i++) {
        setUp();
        press();
        fixture_rig_ticks(&rig, i);
        hal_host_fault_estop(true);
        fixture_rig_tick(&rig);
        hal_host_fault_estop(false);
        fixture_rig_tick(&rig);
        post(cam_request_enable); // before the next plan as well
        fixture_rig_ticks(&rig, 10);
        expect_off("before the next plan");
        expect_refused("after the chain was open");
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
        (void)fixture_rig_until(&rig, state, 60000);
        fixture_rig_ticks(&rig, 16u + at);
        expect_state(state);
        hal_host_fault_drive(true);
        fixture_rig_tick(&rig);
        expect_state(cam_state_fault);
        hal_host_fault_drive(false);
        for (uint32_t i = 0; i < ms(2000) && fixture_rig_state() == cam_state_fault; i++) {
            post(cam_request_reset);
            fixture_rig_tick(&rig);
        }
        expect_off("reset");
        post(cam_request_enable); // before the next plan as well
        fixture_rig_tick(&rig);
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
            fixture_rig_tick(&rig);
            TEST_ASSERT_EQUAL_UINT32_MESSAGE(0, hal_host.out.outputs & hal_out_enable,
                                             names[i / 2u]);
        }
        expect_off(names[i / 2u]);
    }
}

static void test_other_reasons_are_reported_first(void)
{
    hal_host_fault_estop(true);
    fixture_rig_ticks(&rig, 10);
    TEST_ASSERT_EQUAL_INT(cam_err_estop, enable());
    hal_host_fault_estop(false);
    power_on(false);
    fixture_rig_ticks(&rig, ms(100));
    TEST_ASSERT_EQUAL_INT(cam_err_acknowledge_none, enable());
    TEST_ASSERT_EQUAL_INT(cam_err_acknowledge_none, cam_machine_manual(&rig.machine));
    post(cam_request_enable);
    fixture_rig_ticks(&rig, 10);
    expect_off("a port without the button");
}

/// The remaining time does not count below 0.
static void test_remaining_time_ends_at_0(void)
{
    const cam_acknowledge_config_t cfg = {.good_plans = 100};
    for (uint32_t n = 99; n <= 101u; n++) { // at 101 the interrupt has not ended it yet
        const cam_acknowledge_t a = {.phase = cam_acknowledge_given, .n_plans = n};
        TEST_ASSERT_EQUAL_UINT32(n == 99u ? 1 : 0, cam_acknowledge_left(&a, &cfg));
    }
}
