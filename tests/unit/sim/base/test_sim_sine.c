// SPDX-License-Identifier: Apache-2.0
#include "sim_units.h"
#include "unity.h"
#include <math.h> // cosl, sinl

static const double worst = 5e-16;
static const long double two_pi = 6.283185307179586476925286766559L;

static void expect_at(double turn, double part)
{
    const long double angle = two_pi * part;
    TEST_ASSERT_TRUE(fabsl(sim_sine(turn) - sinl(angle)) < worst);
    TEST_ASSERT_TRUE(fabsl(sim_cosine(turn) - cosl(angle)) < worst);
}

/// 4093 is prime, so that no quarter or eighth of a turn is met but at the ends.
static void test_sine_and_cosine_agree_with_the_library_all_round(void)
{
    for (int i = -4093; i <= 4093; i++) {
        expect_at(i / 4093.0, i / 4093.0);
    }
}

/// A run of a day at 3000 r/min has 4 million turns: the error is that of the first turn.
static void test_error_does_not_grow_with_the_number_of_turns(void)
{
    for (int i = 0; i < 4096; i++) {
        const double part = i / 4096.0; // exact, also beside many turns
        expect_at(4320000.0 + part, part);
        expect_at(-4320000.0 - part, -part);
    }
}

static void test_quarters_are_exact(void)
{
    const double sine[4] = {0.0, 1.0, 0.0, -1.0};
    for (int i = -8; i <= 8; i++) {
        TEST_ASSERT_TRUE(fabs(sim_sine(0.25 * i) - sine[(i + 8) % 4]) < worst);
        TEST_ASSERT_TRUE(fabs(sim_cosine(0.25 * i) - sine[(i + 9) % 4]) < worst);
    }
}
