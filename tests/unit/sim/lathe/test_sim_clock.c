// SPDX-License-Identifier: Apache-2.0
// When ticks come: drift, delays spread evenly or in bursts, and a tick that comes twice.
#include "sim_port.h"
#include "unity.h"

#define PERIOD_S 50e-6
enum { clock_hz = 200000000, period_clocks = 10000, n_steps = 100000 };

static sim_clock_t ticks;

void setUp(void)
{
    sim_clock_init(&ticks, 1);
}

static sim_clock_step_t next(void)
{
    return sim_clock_next(&ticks, PERIOD_S, clock_hz);
}

/// A clock that is fast by 1000 ppm ends its period early, and knows nothing of it.
static void test_drift_changes_the_time_of_the_machine_only(void)
{
    sim_clock_step_t step = next();
    TEST_ASSERT_TRUE(step.dt_s == PERIOD_S); // exactly: the lathe takes its short way
    TEST_ASSERT_EQUAL_INT32(0, step.late_clocks);
    ticks.drift = 1e-3;
    step = next();
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, PERIOD_S / 1.001, step.dt_s);
    TEST_ASSERT_EQUAL_INT32(0, step.late_clocks);
}

/// What the delays add up to is the last one's: none is added to the next.
static void test_jitter_is_spread_over_its_range_and_does_not_add_up(void)
{
    ticks.jitter = 0.4;
    double behind = 0.0;
    double least = 1.0;
    double most = 0.0;
    double sum = 0.0;
    for (int i = 0; i < n_steps; i++) {
        const sim_clock_step_t step = next();
        TEST_ASSERT_DOUBLE_WITHIN(0.51, (step.dt_s / PERIOD_S - 1.0) * period_clocks,
                                  step.late_clocks);
        behind += step.dt_s / PERIOD_S - 1.0;
        least = behind < least ? behind : least;
        most = behind > most ? behind : most;
        sum += behind;
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, least);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.4, most);
    TEST_ASSERT_DOUBLE_WITHIN(2e-3, 0.2, sum / n_steps);
}

static void test_burst_hits_one_of_sixteen_ticks(void)
{
    ticks.burst = 0.7;
    double behind = 0.0;
    int n_late = 0;
    for (int i = 0; i < n_steps; i++) {
        behind += next().dt_s / PERIOD_S - 1.0;
        const int is_late = behind > 0.35 ? 1 : 0;
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, is_late * 0.7, behind);
        n_late += is_late;
    }
    TEST_ASSERT_INT_WITHIN(n_steps / 160, n_steps / 16, n_late);
}

static void test_twice_comes_between_two_ticks_of_the_grid(void)
{
    ticks.twice = 0.1;
    TEST_ASSERT_EQUAL_INT32(-9000, next().late_clocks);
    TEST_ASSERT_EQUAL_INT32(-1000, next().late_clocks);
    TEST_ASSERT_EQUAL_INT32(0, next().late_clocks);
}
