// SPDX-License-Identifier: Apache-2.0
// Index edges out of a HAL encoder's two counters.
#include "lcn_index.h"
#include "unity.h"

enum { turn = 1000 };

static lcn_index_t x;
static lcn_counters_t now;

/// The spindle turns by some counts; an edge that is passed and waited for resets the counter.
static void turn_by(int32_t by, int32_t edge_at)
{
    now.raw += by;
    now.counts += by;
    if (now.is_armed && now.raw >= edge_at && now.raw - by < edge_at) {
        now.counts = now.raw - edge_at;
        now.is_armed = false;
    }
    lcn_index_step(&x, &now, turn, false);
    now.is_armed = now.is_armed || x.arms;
}

static void expect(uint32_t n, int32_t counts)
{
    TEST_ASSERT_EQUAL_UINT32(n, x.n);
    TEST_ASSERT_EQUAL_INT32(counts, (int32_t)x.counts);
}

/// Start at 250 counts and turn to 750; the encoder waits for the edge at 700 from 350 on.
static void pass_an_edge(bool is_shared)
{
    x = (lcn_index_t){0};
    now = (lcn_counters_t){.raw = 250, .counts = 250, .is_shared = is_shared};
    lcn_index_step(&x, &now, turn, true);
    now.is_armed = x.arms;
    turn_by(100, 700);
    TEST_ASSERT_TRUE(x.arms);
    TEST_ASSERT_EQUAL_UINT32(0, x.n);
    turn_by(400, 700);
    expect(1, 700);
    TEST_ASSERT_EQUAL(!is_shared, x.arms);
}

static void test_step_alone_every_edge_is_waited_for(void)
{
    pass_an_edge(false);
    for (int32_t i = 0; i < 35; i++) {
        turn_by(100, 1700 + 1000 * (i / 10));
    }
    expect(4, 3700);
}

/// The same edge passed backwards leaves the difference of the counters as it was.
static void test_step_an_edge_at_the_same_place_is_an_edge(void)
{
    pass_an_edge(false);
    now.is_armed = false;
    lcn_index_step(&x, &now, turn, false);
    expect(2, 700);
}

static void test_step_shared_one_edge_is_waited_for_and_the_others_are_due(void)
{
    pass_an_edge(true);
    for (int32_t i = 0; i < 30; i++) {
        turn_by(100, INT32_MAX);
    }
    expect(3, 2700);
    pass_an_edge(true);
    for (int32_t i = 0; i < 12; i++) {
        turn_by(-100, INT32_MAX);
    }
    expect(2, -300);
}

/// An edge that LinuxCNC waited for, three counts off its place: the firmware sees them as lost.
static void test_step_shared_a_foreign_edge_is_reported_where_it_was(void)
{
    pass_an_edge(true);
    now.is_armed = true; // by G33
    turn_by(960, 1703);
    expect(2, 1703);
}

static void test_step_off_forgets_the_index(void)
{
    pass_an_edge(true);
    lcn_index_step(&x, &now, turn, true);
    TEST_ASSERT_FALSE(x.is_known);
    TEST_ASSERT_FALSE(x.arms);
    lcn_index_step(&x, &now, turn, false);
    TEST_ASSERT_TRUE(x.arms);
}
