// SPDX-License-Identifier: Apache-2.0
#include "sim_drive.h"
#include "sim_units.h" // SIM_TWO_PI
#include "unity.h"
#include <math.h> // exp, INFINITY

#define STEP_S 50e-6
#define OMEGA (SIM_TWO_PI * 300.0)

static sim_friction_law_t law;

void setUp(void)
{
    law = (sim_friction_law_t){.stiffness_per_s2 = OMEGA * OMEGA,
                               .drag_per_s = 1.4 * OMEGA,
                               .acceleration_micro_per_s2 = INFINITY,
                               .speed_micro_per_s = INFINITY};
}

/// Move by n steps.
static void move(sim_friction_state_t *s, int n, double push_micro_per_s2,
                 double force_micro_per_s2)
{
    law.longest_s = sim_friction_longest_s(&law);
    for (int i = 0; i < n; i++) {
        sim_friction_move(&law, s, push_micro_per_s2, force_micro_per_s2, STEP_S);
    }
}

/// A free mass under friction alone stops after v^2 / 2 f and stays there.
static void test_free_mass_stops_after_its_way(void)
{
    law.stiffness_per_s2 = 0.0;
    law.drag_per_s = 0.0;
    law.friction_micro_per_s2 = 10e9;
    sim_friction_state_t s = {.vel_micro_per_s = 30e6};
    move(&s, 100, 0.0, 0.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 30e6 * 30e6 / 20e9, s.pos_micro);
    TEST_ASSERT_TRUE(s.vel_micro_per_s == 0.0);
}

/// A disturbing acceleration moves a loop by a / w^2 once it rests.
static void test_force_displaces_the_loop(void)
{
    sim_friction_state_t s = {0};
    move(&s, 400, 0.0, -7e9);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -7e9 / law.stiffness_per_s2, s.pos_micro);
}

/// The push of an amplifier rises by 1 - e^(-t / tau), in rest as in motion.
static void test_amplifier_lags(void)
{
    law.lag_per_s = SIM_TWO_PI * 1000.0;
    law.friction_micro_per_s2 = 1e9;
    sim_friction_state_t s = {0};
    move(&s, 2, 0.9e9, 0.0);
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 0.9e9 * (1.0 - exp(-0.1 * SIM_TWO_PI)), s.push_micro_per_s2);
    TEST_ASSERT_TRUE(s.pos_micro == 0.0);
    move(&s, 2, 9e9, 0.0);
    TEST_ASSERT_TRUE(s.pos_micro > 0.0);
}

static void test_limits_of_speed_and_acceleration_are_kept(void)
{
    law.speed_micro_per_s = 1e6;
    law.acceleration_micro_per_s2 = 2e9;
    sim_friction_state_t s = {0};
    double before = 0.0;
    for (int i = 0; i < 40; i++) {
        move(&s, 1, law.stiffness_per_s2 * 1e6, 0.0);
        TEST_ASSERT_TRUE(s.vel_micro_per_s <= 1e6);
        TEST_ASSERT_TRUE(s.vel_micro_per_s - before <= 2e9 * STEP_S * (1.0 + 1e-9));
        before = s.vel_micro_per_s;
    }
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 1e6, s.vel_micro_per_s);
}
