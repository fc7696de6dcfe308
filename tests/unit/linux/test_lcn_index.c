// SPDX-License-Identifier: Apache-2.0
// Index edges out of a HAL encoder's two counters.
#include "lcn_index.h"
#include "unity.h"

enum { turn = 1000 };

static lcn_index_t x;
static lcn_counters_t now;

static void begin(bool is_shared)
{
    x = (lcn_index_t){0};
    now = (lcn_counters_t){.raw = 250, .counts = 250, .is_shared = is_shared};
    lcn_index_step(&x, &now, turn, true);
    now.is_armed = x.arms;
}

void setUp(void)
{
    begin(false);
}

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

static void test_step_an_edge_that_was_waited_for_is_reported_at_its_place(void)
{
    turn_by(100, 700); // from now on the encoder waits
    TEST_ASSERT_TRUE(x.arms);
    TEST_ASSERT_EQUAL_UINT32(0, x.n);
    turn_by(400, 700);
    TEST_ASSERT_EQUAL_UINT32(1, x.n);
    TEST_ASSERT_EQUAL_UINT32(700, x.counts);
}

static void test_step_alone_every_edge_is_waited_for(void)
{
    for (int32_t i = 0; i < 40; i++) {
        turn_by(100, 700 + 1000 * (i / 10));
    }
    TEST_ASSERT_EQUAL_UINT32(4, x.n);
    TEST_ASSERT_EQUAL_UINT32(3700, x.counts);
}

/// The same edge passed backwards leaves the difference of the counters as it was.
static void test_step_an_edge_at_the_same_place_is_an_edge(void)
{
    turn_by(100, 700);
    turn_by(400, 700);
    now.is_armed = false;
    lcn_index_step(&x, &now, turn, false);
    TEST_ASSERT_EQUAL_UINT32(2, x.n);
    TEST_ASSERT_EQUAL_UINT32(700, x.counts);
}

static void test_step_shared_one_edge_is_waited_for_and_the_others_are_due(void)
{
    begin(true);
    turn_by(100, 700);
    TEST_ASSERT_TRUE(x.arms);
    turn_by(400, 700);
    TEST_ASSERT_FALSE(x.arms);
    for (int32_t i = 0; i < 30; i++) {
        turn_by(100, INT32_MAX);
    }
    TEST_ASSERT_EQUAL_UINT32(3, x.n);
    TEST_ASSERT_EQUAL_UINT32(2700, x.counts);
}

/// An edge that LinuxCNC waited for, three counts off its place: the firmware sees them as lost.
static void test_step_shared_a_foreign_edge_is_reported_where_it_was(void)
{
    begin(true);
    turn_by(100, 700);
    turn_by(400, 700);
    now.is_armed = true; // by G33
    turn_by(960, 1703);
    TEST_ASSERT_EQUAL_UINT32(2, x.n);
    TEST_ASSERT_EQUAL_UINT32(1703, x.counts);
}

static void test_step_shared_backwards_the_edges_are_due_as_well(void)
{
    begin(true);
    turn_by(100, 700);
    turn_by(400, 700);
    for (int32_t i = 0; i < 12; i++) {
        turn_by(-100, INT32_MAX);
    }
    TEST_ASSERT_EQUAL_UINT32(2, x.n);
    TEST_ASSERT_EQUAL_INT32(-300, (int32_t)x.counts);
}

static void test_step_off_forgets_the_index(void)
{
    begin(true);
    turn_by(100, 700);
    turn_by(400, 700);
    lcn_index_step(&x, &now, turn, true);
    TEST_ASSERT_FALSE(x.is_known);
    TEST_ASSERT_FALSE(x.arms);
    lcn_index_step(&x, &now, turn, false);
    TEST_ASSERT_TRUE(x.arms);
}
