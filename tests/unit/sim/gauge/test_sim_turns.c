// SPDX-License-Identifier: Apache-2.0
// The error of each turn, of a rehearsal whose amplitude rises and falls and of the cut behind it.
#include "sim_work.h"
#include "sim_units.h" // SIM_TWO_PI
#include "unity.h"
#include <math.h> // sin

static sim_turns_t turns;
static double turn, step;

enum { ticks_per_turn = 400, rise = 5, kept = 12, fall = 3 };

void setUp(void)
{
    sim_turns_init(&turns, rise, kept, fall);
    turn = 100.3;
    step = 1.0 / ticks_per_turn;
}

/// The drawing is 500 um sin(2 x), less a radius; U is it times the amplitude, and an error.
static void rehearse(double n_turns, double from, double to, double error_um)
{
    const int n = (int)(n_turns * ticks_per_turn + 0.5);
    for (int i = 0; i < n; i++) {
        const double wave = sin(2.0 * SIM_TWO_PI * turn);
        const double amplitude = from + (to - from) * i / n;
        sim_turns_rehearse(&turns, turn, 500.0 * amplitude * wave + error_um * wave + 7.0,
                           45000.0 - 500.0 * wave);
        turn += step;
    }
}

static void cut(double n_turns, double error_um)
{
    const int n = (int)(n_turns * ticks_per_turn + 0.5);
    for (int i = 0; i < n; i++) {
        sim_turns_touch(&turns, turn, i == n / 2 ? -error_um : 0.25 * error_um);
        turn += step;
    }
}

static void rest(double n_turns, bool is_engaging)
{
    for (int i = 0; i < (int)(n_turns * ticks_per_turn); i++) {
        sim_turns_rest(&turns, turn, is_engaging);
        turn += step;
    }
}

static void expect_all_um(uint32_t from, uint32_t to, double um)
{
    for (uint32_t i = from; i < to; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(0.01, um, turns.entry[i].um);
    }
}

static void whole_rehearsal(double error_um)
{
    rehearse(4.37, 0.0, 0.0, 0.0); // the approach: U rests
    rehearse(rise, 0.0, 1.0, 0.0);
    rehearse(kept, 1.0, 1.0, error_um);
    rehearse(fall, 1.0, 0.0, 0.0);
}

static void test_rehearsal_leaves_the_turns_of_full_amplitude(void)
{
    for (int sense = 0; sense < 2; sense++) {
        setUp();
        step = sense == 0 ? step : -step;
        whole_rehearsal(20.0);
        rest(2.0, true);
        TEST_ASSERT_EQUAL_UINT32(kept - 1, turns.n); // whole turns begin with the approach
        expect_all_um(0, turns.n, 20.0);             // the 7 um between U and X are none
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, 10.0, turns.entry[0].turn);
        TEST_ASSERT_EQUAL_INT(sim_turns_rehearsed, turns.entry[0].kind);
    }
}

/// Of two passes.
static void test_cut_behind_it_has_the_largest_error_of_each_turn(void)
{
    const sim_turn_t *first = &turns.entry[kept - 1];
    for (uint32_t pass = 1; pass <= 2u; pass++) {
        whole_rehearsal(20.0);
        rest(6.0, true);
        cut(1.0, 3.0);
        cut(1.0, 2.0);
        cut(0.6, 1.0); // a part of a turn counts
        rest(1.0, false);
        TEST_ASSERT_EQUAL_UINT32(pass * (kept + 2), turns.n);
        TEST_ASSERT_EQUAL_INT(sim_turns_rehearsed, first[-1].kind);
        for (int i = 0; i < 3; i++) {
            TEST_ASSERT_EQUAL_INT(sim_turns_cut, first[i].kind);
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, 3.0 - i, first[i].um);
            TEST_ASSERT_TRUE(first[i].turn > first[i - 1].turn);
        }
        first += kept + 2;
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-2, 4.37 + rise + kept + fall + 6.0, turns.entry[kept - 1].turn);
}

static void test_rehearsal_that_was_broken_off_keeps_what_was_full(void)
{
    rehearse(3.0, 0.0, 0.0, 0.0);
    rehearse(rise, 0.0, 1.0, 0.0);
    rehearse(6.5, 1.0, 1.0, 40.0);
    rest(1.0, false);
    TEST_ASSERT_EQUAL_UINT32(6, turns.n);
    expect_all_um(0, turns.n, 40.0);
    setUp();
    rehearse(9.0, 0.0, 0.0, 0.0); // U never moved
    rest(1.0, false);
    TEST_ASSERT_EQUAL_UINT32(0, turns.n);
}

/// A long cut stays in the memory, and its largest error in the history.
static void test_long_cut_is_thinned_and_keeps_its_peaks(void)
{
    const int n_turns = 3 * sim_turns_most;
    for (int i = 0; i < n_turns; i++) {
        for (int j = 0; j < 4; j++) {
            sim_turns_touch(&turns, turn, i == 777 ? 9.0 : 1.0);
            turn += 0.25;
        }
    }
    rest(1.0, false);
    double most_um = 0.0;
    for (uint32_t i = 0; i < turns.n; i++) {
        most_um = turns.entry[i].um > most_um ? turns.entry[i].um : most_um;
        TEST_ASSERT_TRUE(i == 0u || turns.entry[i].turn > turns.entry[i - 1u].turn);
    }
    TEST_ASSERT_TRUE(turns.n > sim_turns_most / 2 && turns.n <= sim_turns_most);
    TEST_ASSERT_EQUAL_DOUBLE(9.0, most_um);
}
