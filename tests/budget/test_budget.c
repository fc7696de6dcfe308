// SPDX-License-Identifier: Apache-2.0
// Exact instructions of every tick on the emulated core: all states, faults in the cut, both
// senses, counter wraps, uniform and modulated tables, few and many knots, random parameters.
#include "budget.h"
#include "budget_count.h"
#include "budget_force.h"
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
static budget_spread_t ticks[cam_n_states]; ///< without a plan, of one session, by the state after
static budget_spread_t plans[cam_n_states]; ///< ... with one
static uint32_t per_reading;                ///< [instructions] what measuring costs
static uint32_t n_measured;                 ///< ticks of all sessions
static uint32_t most_in_cut;                ///< [instructions] of an ordinary tick in the cut
static uint32_t most;                       ///< [instructions] of any tick without a plan
static uint32_t most_with_plan;             ///< [instructions] of any tick with one

void setUp(void)
{
    memset(ticks, 0, sizeof ticks);
    memset(plans, 0, sizeof plans);
    budget_count_start();
    const uint32_t from = budget_count();
    per_reading = budget_instructions(from, budget_count());
}

/// The interrupt by its address, so that it stays a function of its own.
static void (*volatile const interrupt)(void) = cam_isr;

/// @return whether U plays the table, and nothing rare happens
static bool is_ordinary_in_cut(cam_state_t state)
{
    const bool plays =
        state == cam_state_cutting || state == cam_state_disengaging || state == cam_state_holding;
    return plays && !budget_force_is_combined();
}

/// The rig calls this instead of cam_isr(). In the tick of a plan the next one is a whole period
/// away.
static void counted(void)
{
    const uint32_t from = budget_count();
    interrupt();
    const uint32_t n = budget_instructions(from, budget_count()) - per_reading;
    const bool is_planned = g_cam.until_plan == g_cam.config.in_use->play.plan_ticks;
    const cam_state_t state = g_cam.motion.state;
    budget_spread_add(is_planned ? &plans[state] : &ticks[state], n);
    uint32_t *largest = is_planned ? &most_with_plan : &most;
    *largest = n > *largest ? n : *largest;
    if (!is_planned && is_ordinary_in_cut(state) && n > most_in_cut) {
        most_in_cut = n;
    }
    n_measured++;
}

static void set(cam_param_id_t id, int32_t value)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&rig, id, value));
}

static void whole_cut(const fixture_part_t *part)
{
    TEST_ASSERT_TRUE(budget_session_cut(&rig, counted, part));
}

static void expect_budget(const char *session)
{
    budget_spread_print(session, "tick", ticks);
    budget_spread_print(session, "plan", plans);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32_MESSAGE(budget_tick_in_cut, most_in_cut, session);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32_MESSAGE(budget_tick, most, session);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32_MESSAGE(budget_tick, most_with_plan, session);
}

/// Without a fault a tick takes nearly the same time all through the cut.
static void expect_even(void)
{
    const budget_spread_t *cutting = &ticks[cam_state_cutting];
    TEST_ASSERT_GREATER_THAN_UINT32(0, cutting->n);
    const uint32_t spread = cutting->max - cutting->min;
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(cutting->max * budget_spread_percent / 100u, spread);
}

/// [instructions] mean of all ticks in the state cutting
static uint32_t mean_in_cut(void)
{
    budget_spread_t all = ticks[cam_state_cutting];
    all.n += plans[cam_state_cutting].n;
    all.sum += plans[cam_state_cutting].sum;
    return budget_spread_mean(&all);
}

static void test_uniform_cut(void)
{
    const fixture_part_t part = fixture_part_short();
    whole_cut(&part);
    expect_budget("uniform");
    expect_even();
    printf("figure mean_uniform %lu\n", (unsigned long)mean_in_cut());
}

/// Z along a ring-helix, to the end and stopped.
static void test_ring_helix_cut(void)
{
    fixture_part_t part = fixture_part_short();
    part.is_ring_helix = true;
    whole_cut(&part);
    TEST_ASSERT_TRUE(budget_session_open(&rig, counted, &part));
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    fixture_rig_ticks(&rig, 700);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(&rig.machine));
    TEST_ASSERT_LESS_THAN_UINT32(60000, fixture_rig_until(&rig, cam_state_ready, 60000));
    expect_budget("rings");
}

static void test_modulated_cut(void)
{
    const fixture_part_t part = fixture_part_modulated();
    whole_cut(&part);
    expect_budget("modulated");
    expect_even();
    printf("figure mean_modulated %lu\n", (unsigned long)mean_in_cut());
}

/// Against the positive sense, with the counter wrapping in the cut.
static void test_other_sense_and_wrapping_counter(void)
{
    fixture_part_t part = fixture_part_short();
    part.direction = -1;
    fixture_rig_init(&rig, &part, tick_hz);
    rig.isr = counted;
    fixture_encoder_init(&rig.lathe.encoder, 10000, 1, 60000u, 1234);
    set(cam_param_following_limit_nm, 10000000);
    fixture_rig_ticks(&rig, 10); // a plan forgets the index of the other encoder
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    TEST_ASSERT_LESS_THAN_UINT32(60000, fixture_rig_until(&rig, cam_state_ready, 60000));
    expect_budget("reverse");
}

/// The smallest table, and one of 512 knots a turn: the interrupt does the same work.
static void test_size_of_the_table_costs_nothing(void)
{
    const fixture_part_t small = fixture_part_smallest();
    whole_cut(&small);
    expect_budget("4 knots");
    const uint32_t few = ticks[cam_state_cutting].max;
    setUp();
    fixture_part_t part = fixture_part_short();
    part.log2_knots = 9;
    whole_cut(&part);
    expect_budget("512 knots");
    TEST_ASSERT_UINT32_WITHIN(few / 10u, few, ticks[cam_state_cutting].max);
}

static void open_swung(void)
{
    fixture_part_t part = fixture_part_swung();
    part.speed = fixture_ratio;
    TEST_ASSERT_TRUE(budget_session_swung(&rig, counted, &part));
}

static void open_modulated(void)
{
    const fixture_part_t part = fixture_part_modulated();
    TEST_ASSERT_TRUE(budget_session_open(&rig, counted, &part));
}

static void open_rings(void)
{
    fixture_part_t part = fixture_part_short();
    part.is_ring_helix = true;
    TEST_ASSERT_TRUE(budget_session_open(&rig, counted, &part));
}

static void open_measured(void)
{
    open_modulated();
    set(cam_param_z_is_measured, 1);
}

static void open_way(void)
{
    TEST_ASSERT_TRUE(budget_session_way(&rig, counted));
}

static void test_every_edge_and_fault_in_every_state(void)
{
    static const struct {
        const char *name;
        void (*open)(void);
    } sessions[] = {
        {"forced 4", open_swung},
        {"forced 3", open_modulated},
        {"rings", open_rings}, ///< along a ring-helix, in a ring, on a ramp and between two
        {"forced way", open_way},
        {"measured", open_measured}, ///< Z is read in every plan, and X approaches over it
    };
    for (uint32_t i = 0; i < sizeof sessions / sizeof sessions[0]; i++) {
        setUp();
        TEST_ASSERT_TRUE_MESSAGE(budget_force_states(&rig, sessions[i].open), sessions[i].name);
        expect_budget(sessions[i].name);
    }
}

/// A shaft from lobe to lobe, with everything that a table can hold.
static void test_shaft(void)
{
    TEST_ASSERT_TRUE(budget_session_shaft(&rig, counted));
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    TEST_ASSERT_LESS_THAN_UINT32(60000, fixture_rig_until(&rig, cam_state_ready, 60000));
    TEST_ASSERT_EQUAL_HEX32(0, rig.last.want.faults);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(2, g_cam.plan.shaft.i_lobe, "all three were played");
    expect_budget("shaft");
}

/// Poll, as the slow side does, and start what comes next.
static bool bring_next_pass(void)
{
    cam_machine_poll(&rig.machine);
    fixture_rig_ticks(&rig, 8000); // the spindle comes to the speed of the pass
    return cam_machine_start(&rig.machine) == cam_ok &&
           fixture_rig_until(&rig, cam_state_cutting, 60000) < 60000u;
}

/// The feed against the height in the second of two passes, with speed and swing.
static void test_way(void)
{
    TEST_ASSERT_TRUE(budget_session_way(&rig, counted));
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    for (int pass = 1; pass <= 2; pass++) {
        TEST_ASSERT_LESS_THAN_UINT32(60000, fixture_rig_until(&rig, cam_state_ready, 60000));
        TEST_ASSERT_EQUAL_HEX32(0, rig.last.want.faults);
        TEST_ASSERT_TRUE(pass == 2 || bring_next_pass());
    }
    expect_budget("way");
}

static void test_other_sessions(void)
{
    static const struct {
        const char *name;
        bool (*play)(fixture_rig_t *rig, void (*isr)(void));
        cam_state_t state;    ///< in which it must be
        uint32_t least_ticks; ///< ... for so many without a plan
    } sessions[] = {
        {"faults", budget_session_faults, cam_state_fault, 1000},
        {"identify", budget_session_identify, cam_state_identifying, 1000},
        {"hand", budget_session_hand, cam_state_manual, 1000},
        {"hold", budget_session_hold, cam_state_holding, 500},
        {"rehearse", budget_session_rehearse, cam_state_rehearsing, 1000},
    };
    for (uint32_t i = 0; i < sizeof sessions / sizeof sessions[0]; i++) {
        setUp();
        TEST_ASSERT_TRUE_MESSAGE(sessions[i].play(&rig, counted), sessions[i].name);
        TEST_ASSERT_GREATER_THAN_UINT32(sessions[i].least_ticks, ticks[sessions[i].state].n);
        expect_budget(sessions[i].name);
    }
}

/// A cam: the swing alone and with the speed ratio, in the work and on its return to 0.
static void test_swung_cuts(void)
{
    fixture_part_t part = fixture_part_swung();
    TEST_ASSERT_TRUE(budget_session_swung(&rig, counted, &part));
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    fixture_rig_ticks(&rig, 25000);
    expect_budget("swung");
    expect_even();
    setUp();
    open_swung();
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    fixture_rig_ticks(&rig, 25000);
    expect_even();
    printf("figure mean %lu\n", (unsigned long)mean_in_cut());
    hal_host_fault_estop(true);
    fixture_rig_ticks(&rig, 5000);
    TEST_ASSERT_TRUE(rig.last.want.is_retracted);
    TEST_ASSERT_EQUAL_INT32(0, g_cam.motion.swing.set.vel_q32);
    expect_budget("both");
}

/// Phase, amplitude, lead, gains and envelope at random, changed in the cut as far as allowed.
static void test_random_parameters(void)
{
    fixture_random_t random = {.state = 11};
    for (int i = 0; i < 4; i++) {
        const fixture_part_t part = fixture_part_short();
        TEST_ASSERT_TRUE(budget_session_open(&rig, counted, &part));
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
    expect_budget("random");
}

/// A cut in which the firmware closes the loop of U. Its counts are apart.
static void test_force_of_u(void)
{
    const fixture_part_t part = fixture_part_short();
    const uint32_t without = most_in_cut;
    most_in_cut = 0;
    TEST_ASSERT_TRUE(budget_session_force(&rig, counted, &part));
    printf("figure tick_force_max %lu\n", (unsigned long)most_in_cut);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(budget_tick_with_force, most_in_cut);
    most_in_cut = without;
    expect_budget("force");
}

static void test_enough_ticks_were_measured(void)
{
    TEST_ASSERT_GREATER_THAN_UINT32(least_ticks, n_measured);
    TEST_ASSERT_GREATER_THAN_UINT32(0, most_in_cut);
    printf("figure tick_cut_max %lu\n", (unsigned long)most_in_cut);
    printf("figure tick_max %lu\n", (unsigned long)most);
    printf("figure plan_tick_max %lu\n", (unsigned long)most_with_plan);
}
