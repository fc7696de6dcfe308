// SPDX-License-Identifier: Apache-2.0
#include "sim_live.h"
#include "unity.h"

static sim_pace_t pace;

static void test_tick_takes_its_share_of_the_clock(void)
{
    sim_pace_init(&pace, 20000.0, 4.0);
    TEST_ASSERT_TRUE(pace.tick_ns == 12500.0 && pace.lost_ns == 0.0);
    const double begin_ns = pace.due_ns;
    sim_pace_tick(&pace);
    TEST_ASSERT_TRUE(pace.due_ns == begin_ns + pace.tick_ns);
}

static void test_tick_far_ahead_waits_for_the_clock(void)
{
    sim_pace_init(&pace, 100.0, 1.0); // a tick of 10 ms
    const double begin_ns = pace.due_ns;
    sim_pace_tick(&pace);
    sim_pace_t now;
    sim_pace_init(&now, 100.0, 1.0); // its due time is the present
    TEST_ASSERT_TRUE(now.due_ns >= begin_ns + 0.9e7);
}

static void test_tick_far_behind_gives_the_time_up(void)
{
    sim_pace_init(&pace, 20000.0, 1.0);
    pace.due_ns -= 1e10;
    const double was_ns = pace.due_ns;
    sim_pace_tick(&pace);
    TEST_ASSERT_TRUE(pace.lost_ns >= 0.99e10);
    TEST_ASSERT_TRUE(pace.due_ns >= was_ns + 0.99e10);
}
