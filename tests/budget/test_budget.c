// SPDX-License-Identifier: Apache-2.0
// Exact instructions of every tick on the emulated core: all states, faults in the cut, both
// senses, counter wraps, uniform and modulated tables, few and many knots, random parameters.
#include "budget.h"
#include "budget_count.h"
#include "budget_session.h"
#include "cam_tick.h"
#include "fixture_random.h"
#include "fixture_rig.h"
#include "hal_host.h"
#include "unity.h"
#include <stdio.h>  // printf
#include <string.h> // memset

enum { tick_hz = 20000, least_ticks = 100000 };

static fixture_rig_t rig;
static budget_spread_t ticks[cam_n_states]; ///< of one session, by the state after the tick
static uint32_t per_reading;                ///< [instructions] what measuring costs
static uint32_t n_measured;                 ///< ticks of all sessions
static uint32_t most;                       ///< [instructions] of any tick of all sessions

void setUp(void)
{
    memset(ticks, 0, sizeof ticks);
    budget_count_start();
    const uint32_t from = budget_count();
    per_reading = budget_instructions(from, budget_count());
}

void tearDown(void) {}

/// The interrupt by its address, so that it stays a function of its own.
static void (*volatile const interrupt)(void) = cam_isr;

/// The rig calls this instead of cam_isr().
static void counted(void)
{
    const uint32_t from = budget_count();
    interrupt();
    const uint32_t n = budget_instructions(from, budget_count()) - per_reading;
    budget_spread_add(&ticks[g_cam.motion.state], n);
    n_measured++;
    most = n > most ? n : most;
}

static void set(cam_param_id_t id, int32_t value)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&rig, id, value));
}

static void whole_cut(const fixture_part_t *part, bool is_modulated)
{
    TEST_ASSERT_TRUE(budget_session_cut(&rig, counted, part, is_modulated));
}

static void expect_budget(const char *session, uint32_t in_work)
{
    budget_spread_print(session, ticks);
    for (int state = 0; state < cam_n_states; state++) {
        const bool is_idle = state == cam_state_off || state == cam_state_homing;
        TEST_ASSERT_LESS_OR_EQUAL_UINT32_MESSAGE(is_idle ? budget_idle : in_work, ticks[state].max,
                                                 "budget.test_stages tells which stage grew");
    }
    const budget_spread_t *cutting = &ticks[cam_state_cutting];
    TEST_ASSERT_GREATER_THAN_UINT32(0, cutting->n);
    const uint32_t spread = cutting->max - cutting->min;
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(cutting->max * budget_spread_percent / 100u, spread);
}

static void test_uniform_cut(void)
{
    const fixture_part_t part = fixture_part_short();
    whole_cut(&part, false);
    expect_budget("uniform", budget_tick);
}

/// Z along a ring-helix, to the end and stopped.
static void test_ring_helix_cut(void)
{
    fixture_part_t part = fixture_part_short();
    part.is_ring_helix = true;
    whole_cut(&part, false);
    TEST_ASSERT_TRUE(budget_session_open(&rig, counted, &part, false));
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    fixture_rig_ticks(&rig, 700);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(&rig.machine));
    TEST_ASSERT_LESS_THAN_UINT32(60000, fixture_rig_until(&rig, cam_state_ready, 60000));
    expect_budget("rings", budget_tick);
}

static void test_modulated_cut(void)
{
    const fixture_part_t part = fixture_part_modulated();
    whole_cut(&part, true);
    expect_budget("modulated", budget_tick);
}

/// Against the positive sense, with the counter wrapping in the cut.
static void test_other_sense_and_wrapping_counter(void)
{
    fixture_part_t part = fixture_part_short();
    part.direction = -1;
    fixture_rig_init(&rig, &part, tick_hz);
    rig.isr = counted;
    fixture_encoder_init(&rig.encoder, 10000, 1, 60000u, 1234);
    set(cam_param_following_limit_nm, 10000000);
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    TEST_ASSERT_LESS_THAN_UINT32(60000, fixture_rig_until(&rig, cam_state_ready, 60000));
    expect_budget("reverse", budget_tick);
}

/// The smallest table, and one of 512 knots a turn: the interrupt does the same work.
static void test_size_of_the_table_costs_nothing(void)
{
    const fixture_part_t small = fixture_part_smallest();
    whole_cut(&small, false);
    expect_budget("4 knots", budget_tick);
    const uint32_t few = ticks[cam_state_cutting].max;
    setUp();
    fixture_part_t part = fixture_part_short();
    part.log2_knots = 9;
    whole_cut(&part, false);
    expect_budget("512 knots", budget_tick);
    TEST_ASSERT_UINT32_WITHIN(few / 10u, few, ticks[cam_state_cutting].max);
}

/// Every fault that the port can cause, with the retract behind it.
static void test_faults_in_the_cut(void)
{
    TEST_ASSERT_TRUE(budget_session_faults(&rig, counted));
    expect_budget("faults", budget_tick);
}

/// One tick from where the session stands, then back: a task, a step of an index edge, a cause of
/// a fault.
static void try_tick(uint32_t task, uint32_t edge_step, void (*cause)(void))
{
    static cam_t controller;
    static hal_host_t port;
    controller = g_cam;
    port = hal_host;
    const fixture_rig_t before = rig;
    g_cam.play.task = task;
    g_cam.spindle.edge_step = (uint8_t)edge_step;
    cause();
    fixture_rig_tick(&rig);
    rig = before;
    hal_host = port;
    g_cam = controller;
}

static void no_fault(void) {}

static void press_estop(void)
{
    hal_host_fault_estop(true);
}

/// All that the guard itself finds wrong: U does not follow, its set-point jumps, the drives fail.
static void break_u(void)
{
    hal_host_fault_drive(true);
    hal_host.in.axis_nm[hal_axis_u] += 1 << 24;
    hal_host.in.swing_q32 += 1 << 30;
    g_cam.guard.u_set_q6 += 1 << 24;
}

/// The spindle turns the other way.
static void turn_back(void)
{
    g_cam.spindle.speed_q64 = -g_cam.spindle.speed_q64;
}

static void come_late(void)
{
    hal_host_fault_late(300);
    hal_host_fault_estop(true);
}

/// No fault, but the long way through the angle.
static void come_off_time(void)
{
    hal_host_fault_late(40);
}

static void break_u_off_time(void)
{
    come_off_time();
    break_u();
}

/// The last task of the round that may be put off, then one more.
static void break_u_off_time_again(void)
{
    break_u_off_time();
    g_cam.play.put_off_left = 1;
}

static void come_off_time_too_often(void)
{
    come_off_time();
    g_cam.play.put_off_left = 0;
}

/// The operator's stop, which takes the place of a task.
static void ask_to_stop(void)
{
    const uint32_t serial = g_cam.play.request + 1u;
    atomic_store(&g_cam.request, serial << 8 | (uint32_t)cam_request_stop);
}

static void break_u_while_stopping(void)
{
    ask_to_stop();
    break_u();
}

typedef void (*cause_t)(void);

static void try_tasks(uint32_t from, uint32_t to, const cause_t *causes, uint32_t n_causes)
{
    for (uint32_t task = from; task < to; task++) {
        for (uint32_t step = 0; step < cam_edge_steps; step++) {
            for (uint32_t i = 0; i < n_causes; i++) {
                try_tick(task, step, causes[i]);
            }
        }
    }
}

static void try_every_tick(cam_state_t state, uint32_t ticks_into, const cause_t *causes,
                           uint32_t n_causes, bool is_swung)
{
    fixture_part_t part = is_swung ? fixture_part_swung() : fixture_part_modulated();
    part.speed = fixture_ratio;
    TEST_ASSERT_TRUE(is_swung ? budget_session_swung(&rig, counted, &part)
                              : budget_session_open(&rig, counted, &part, true));
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, state));
    while (!g_cam.motion.is_playing) {
        fixture_rig_tick(&rig);
    }
    fixture_rig_ticks(&rig, ticks_into);
    TEST_ASSERT_EQUAL_INT(state, rig.last.want.state);
    try_tasks(0, (uint32_t)g_cam.config.offered->play.round_ticks, causes, n_causes);
}

static void try_all(const cause_t *causes, uint32_t n_causes)
{
    for (int i = 0; i < 2; i++) {
        try_every_tick(cam_state_engaging, 1500, causes, n_causes, i == 1);
        try_every_tick(cam_state_cutting, 200, causes, n_causes, i == 1);
        try_every_tick(cam_state_disengaging, 300, causes, n_causes, i == 1);
    }
}

/// The worst that can come together, by force: every task with every step of an index edge, without
/// a fault and with those that take the longest ways.
static void test_every_task_with_every_edge_and_fault(void)
{
    static const cause_t causes[] = {no_fault,
                                     press_estop,
                                     break_u,
                                     turn_back,
                                     come_late,
                                     come_off_time,
                                     break_u_off_time,
                                     break_u_off_time_again,
                                     come_off_time_too_often,
                                     ask_to_stop,
                                     break_u_while_stopping};
    try_all(causes, sizeof causes / sizeof causes[0]);
    expect_budget("forced", budget_tick);
}

/// The tasks that a ring-helix does in another way, in a ring, on a ramp and between two.
static void test_ring_helix_with_every_edge_and_fault(void)
{
    static const cause_t causes[] = {
        no_fault,  press_estop,      break_u,     turn_back,
        come_late, break_u_off_time, ask_to_stop, break_u_while_stopping};
    fixture_part_t part = fixture_part_short();
    part.is_ring_helix = true;
    TEST_ASSERT_TRUE(budget_session_open(&rig, counted, &part, false));
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    for (int i = 0; i < 48; i++) { // two turns
        fixture_rig_ticks(&rig, 20);
        try_tasks(cam_plan_task_positions, cam_plan_task_x_rise, causes,
                  sizeof causes / sizeof causes[0]);
    }
    expect_budget("rings", budget_tick);
}

/// A cam: the swing's tasks, alone and with those of the speed ratio, in the work and on the way
/// back to 0.
static void test_swung_cuts(void)
{
    fixture_part_t part = fixture_part_swung();
    TEST_ASSERT_TRUE(budget_session_swung(&rig, counted, &part));
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    fixture_rig_ticks(&rig, 25000);
    expect_budget("swung", budget_tick);
    part.speed = fixture_ratio;
    TEST_ASSERT_TRUE(budget_session_swung(&rig, counted, &part));
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    fixture_rig_ticks(&rig, 25000);
    hal_host_fault_estop(true);
    fixture_rig_ticks(&rig, 5000);
    TEST_ASSERT_TRUE(rig.last.want.is_retracted);
    TEST_ASSERT_EQUAL_INT32(0, g_cam.motion.swing.set.vel_q32);
    expect_budget("both", budget_tick);
}

/// Z led by others: it is read in every tick, and X approaches over it.
static void test_measured_z(void)
{
    const fixture_part_t part = fixture_part_modulated();
    TEST_ASSERT_TRUE(budget_session_open(&rig, counted, &part, true));
    set(cam_param_z_is_measured, 1);
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    fixture_rig_ticks(&rig, 5000);
    expect_budget("measured", budget_tick);
}

/// Phase, amplitude, lead, gains and envelope at random, changed in the cut as far as allowed.
static void test_random_parameters(void)
{
    fixture_random_t random = {.state = 11};
    for (int i = 0; i < 4; i++) {
        const fixture_part_t part = fixture_part_short();
        TEST_ASSERT_TRUE(budget_session_open(&rig, counted, &part, false));
        set(cam_param_lead_ns, (int32_t)fixture_random_range(&random, 0, 2000000));
        set(cam_param_xz_lag_ns, (int32_t)fixture_random_range(&random, 0, 5000000));
        set(cam_param_k1_ns, (int32_t)fixture_random_range(&random, 0, 1000000));
        set(cam_param_k2_us2, (int32_t)fixture_random_range(&random, 0, 1000000));
        set(cam_param_engage_turns, (int32_t)fixture_random_range(&random, 3, 6));
        TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
        for (int k = 0; k < 200 && rig.last.want.state == cam_state_cutting; k++) {
            set(cam_param_phase_udeg, (int32_t)fixture_random_range(&random, -900000, 900000));
            set(cam_param_amplitude_ppm, (int32_t)fixture_random_range(&random, 900000, 1000000));
            fixture_rig_ticks(&rig, 8);
        }
    }
    expect_budget("random", budget_tick);
}

static void test_enough_ticks_were_measured(void)
{
    TEST_ASSERT_GREATER_THAN_UINT32(least_ticks, n_measured);
    printf("budget-max %lu\n", (unsigned long)most); // tools/elfcheck compares its bound with it
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_uniform_cut);
    RUN_TEST(test_modulated_cut);
    RUN_TEST(test_ring_helix_cut);
    RUN_TEST(test_other_sense_and_wrapping_counter);
    RUN_TEST(test_size_of_the_table_costs_nothing);
    RUN_TEST(test_faults_in_the_cut);
    RUN_TEST(test_every_task_with_every_edge_and_fault);
    RUN_TEST(test_ring_helix_with_every_edge_and_fault);
    RUN_TEST(test_swung_cuts);
    RUN_TEST(test_measured_z);
    RUN_TEST(test_random_parameters);
    RUN_TEST(test_enough_ticks_were_measured);
    return UNITY_END();
}
