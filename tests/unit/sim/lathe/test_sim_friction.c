// SPDX-License-Identifier: Apache-2.0
#include "sim_friction.h"
#include "sim_drive.h" // sim_drive_flow
#include "sim_units.h" // SIM_TWO_PI
#include "unity.h"
#include <math.h> // fabs

#define STEP_S 50e-6
#define OMEGA (SIM_TWO_PI * 300.0)

static sim_friction_law_t law;

void setUp(void)
{
    law = (sim_friction_law_t){
        .stiffness_per_s2 = OMEGA * OMEGA,
        .drag_per_s = 1.4 * OMEGA,
        .acceleration_micro_per_s2 = INFINITY,
        .speed_micro_per_s = INFINITY,
    };
    law.longest_s = sim_friction_longest_s(&law);
}

/// A loop of 300 Hz without friction has the exact flow of sim_drive.h.
static void test_without_friction_it_is_the_exact_flow(void)
{
    const sim_drive_flow_t flow = sim_drive_flow(OMEGA, 0.7, STEP_S);
    sim_friction_state_t s = {.pos_micro = 1e6};
    double pos = 1e6;
    double vel = 0.0;
    for (int i = 0; i < 200; i++) {
        sim_friction_move(&law, &s, 0.0, 0.0, STEP_S);
        const double next = flow.pp * pos + flow.pv * vel;
        vel = flow.vp * pos + flow.vv * vel;
        pos = next;
        TEST_ASSERT_DOUBLE_WITHIN(0.005, pos, s.pos_micro); // of 1 mm
    }
}

/// A free mass under friction alone stops after v^2 / 2 f and stays there.
static void test_free_mass_stops_after_its_way(void)
{
    law.stiffness_per_s2 = 0.0;
    law.drag_per_s = 0.0;
    law.friction_micro_per_s2 = 10e9;
    law.longest_s = sim_friction_longest_s(&law);
    sim_friction_state_t s = {.vel_micro_per_s = 30e6};
    for (int i = 0; i < 100; i++) {
        sim_friction_move(&law, &s, 0.0, 0.0, STEP_S);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 30e6 * 30e6 / 20e9, s.pos_micro);
    TEST_ASSERT_TRUE(s.vel_micro_per_s == 0.0);
}

/// Coulomb damping: each half swing of a spring is smaller by 2 f / w^2, until it sticks.
static void test_swing_shrinks_by_a_constant_each_half(void)
{
    law.drag_per_s = 0.0;
    law.friction_micro_per_s2 = 1e9;
    law.longest_s = sim_friction_longest_s(&law);
    const double shrinks = 2.0 * law.friction_micro_per_s2 / law.stiffness_per_s2;
    sim_friction_state_t s = {.pos_micro = 6.25 * shrinks};
    double sign = 1.0;
    int halves = 0;
    for (int i = 0; i < 3000; i++) {
        const sim_friction_state_t before = s;
        sim_friction_move(&law, &s, 0.0, 0.0, STEP_S / 10.0);
        if (before.vel_micro_per_s * s.vel_micro_per_s < 0.0) {
            halves++;
            sign = -sign;
            const double place = (6.25 - halves) * shrinks * sign;
            TEST_ASSERT_DOUBLE_WITHIN(0.002 * shrinks, place, s.pos_micro);
        }
    }
    TEST_ASSERT_EQUAL_INT(5, halves); // the sixth ends within f / w^2 of the middle
    TEST_ASSERT_TRUE(s.vel_micro_per_s == 0.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.25 * shrinks, s.pos_micro);
}

static void test_it_sticks_while_the_force_is_below_the_friction(void)
{
    law.friction_micro_per_s2 = 5e9;
    sim_friction_state_t s = {.pos_micro = 123.0};
    const double hold = law.stiffness_per_s2 * 123.0;
    sim_friction_move(&law, &s, hold + 3e9, 1.99e9, STEP_S);
    TEST_ASSERT_TRUE(s.pos_micro == 123.0);
    TEST_ASSERT_TRUE(s.vel_micro_per_s == 0.0);
    sim_friction_move(&law, &s, hold - 3e9, -2.01e9, STEP_S);
    TEST_ASSERT_TRUE(s.pos_micro < 123.0);
}

/// A disturbing acceleration moves a loop by a / w^2 once it rests.
static void test_force_displaces_the_loop(void)
{
    sim_friction_state_t s = {0};
    for (int i = 0; i < 400; i++) {
        sim_friction_move(&law, &s, 0.0, -7e9, STEP_S);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -7e9 / law.stiffness_per_s2, s.pos_micro);
}

/// The push of an amplifier rises by 1 - e^(-t / tau), in rest as in motion.
static void test_amplifier_lags(void)
{
    law.lag_per_s = SIM_TWO_PI * 1000.0;
    law.friction_micro_per_s2 = 1e9;
    law.longest_s = sim_friction_longest_s(&law);
    sim_friction_state_t s = {0};
    sim_friction_move(&law, &s, 0.9e9, 0.0, 100e-6);
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 0.9e9 * (1.0 - exp(-0.1 * SIM_TWO_PI)), s.push_micro_per_s2);
    TEST_ASSERT_TRUE(s.pos_micro == 0.0);
    sim_friction_move(&law, &s, 9e9, 0.0, 100e-6);
    TEST_ASSERT_TRUE(s.pos_micro > 0.0);
}

static void test_limits_of_speed_and_acceleration_are_kept(void)
{
    law.speed_micro_per_s = 1e6;
    law.acceleration_micro_per_s2 = 2e9;
    sim_friction_state_t s = {0};
    double before = 0.0;
    for (int i = 0; i < 40; i++) {
        sim_friction_move(&law, &s, law.stiffness_per_s2 * 1e6, 0.0, STEP_S);
        TEST_ASSERT_TRUE(s.vel_micro_per_s <= 1e6);
        TEST_ASSERT_TRUE(s.vel_micro_per_s - before <= 2e9 * STEP_S * (1.0 + 1e-9));
        before = s.vel_micro_per_s;
    }
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 1e6, s.vel_micro_per_s);
}
