// SPDX-License-Identifier: Apache-2.0
// The ring-helix as numbers: ramps, speeds, heights against exact arithmetic in double.
#include "cam_motion.h"
#include "fixture_random.h"
#include "unity.h"
#include <math.h>

static const double turn_q32 = 4294967296.0;

/// @return share of the step that is fed at a share of a helix turn
static double exact_risen(double share, double r)
{
    const double near = fmin(share, 1.0 - share);
    const double fed = (near < r ? near * near / (2.0 * r) : near - r / 2.0) / (1.0 - r);
    return share <= 0.5 ? fed : 1.0 - fed;
}

static void test_ramp_is_the_shortest_that_the_acceleration_allows(void)
{
    TEST_ASSERT_EQUAL_HEX32(0x01000000u, cam_feed_ramp_q32(1, 1, 1000000)); // at least a 256th
    TEST_ASSERT_EQUAL_HEX32(0x80000000u, cam_feed_ramp_q32(10000000, 60000000, 10)); // at most half
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0960267, cam_feed_ramp_q32(100000, 2500000, 2000) / turn_q32);
    fixture_random_t random = {.state = 5};
    for (int i = 0; i < 20000 / fixture_rarer; i++) {
        const uint32_t feed_nm =
            (uint32_t)fixture_random_range(&random, 4, 10000000) >> (i % 20) | 4u;
        const uint32_t mrpm = (uint32_t)fixture_random_range(&random, 1, 60000000) >> (i % 17);
        const uint32_t acceleration = (uint32_t)fixture_random_range(&random, 10, 1000000);
        const double per_s = mrpm / 60e3;
        const double inner = 1.0 - 4.0 * feed_nm * 1e-6 * per_s * per_s / acceleration;
        const double exact = inner > 0.0 ? fmax(0.5 - 0.5 * sqrt(inner), 1.0 / 256.0) : 0.5;
        const double ramp = cam_feed_ramp_q32(feed_nm, mrpm, acceleration) / turn_q32;
        TEST_ASSERT_TRUE(ramp > exact - 1e-9); // never too short
        if (exact < 0.49 && mrpm > 10000u) {
            TEST_ASSERT_DOUBLE_WITHIN(2e-4 * exact + 6e-8, exact, ramp);
        }
    }
}

static void test_speed_and_acceleration_of_worked_numbers(void)
{
    const uint32_t ramp_q32 = cam_feed_ramp_q32(100000, 2500000, 2000);
    TEST_ASSERT_EQUAL_UINT64(4610, cam_feed_speed_um_per_s(100000, 2500000, ramp_q32));
    TEST_ASSERT_EQUAL_UINT64(695, cam_feed_least_acceleration(100000, 2500000)); // 694.4
}

/// llround() of the boards' newlib loses bits beyond 2^32.
/// @return [nm] above the first ring
static int32_t height_nm(const cam_rings_t *rings, double turns)
{
    const int64_t done_q32 = (int64_t)(turns * turn_q32 + 0.5);
    return cam_feed_height_nm_isr(rings, done_q32);
}

/// Against the law in double, one rounding to a nanometre.
static void check_heights(uint32_t feed_nm, int32_t span_nm, uint32_t mrpm, uint32_t acceleration)
{
    const cam_rings_t rings = cam_feed_rings(feed_nm, span_nm, mrpm, acceleration);
    const double r = rings.ramp_q32 / turn_q32;
    const double turns = (double)cam_feed_turns_q32(&rings) / turn_q32;
    const double step = turns / 4000.0 + 0.000731;
    for (double at = 0.0; at <= turns; at += step) {
        const double ring_nm = fmin(floor(at / 2.0) * feed_nm, span_nm);
        const double step_nm = fmin(feed_nm, span_nm - ring_nm);
        const bool is_ring = fmod(floor(at), 2.0) == 0.0;
        const double risen = is_ring ? 0.0 : exact_risen(at - floor(at), r);
        TEST_ASSERT_DOUBLE_WITHIN(0.5 + step_nm * 1.5e-8, ring_nm + risen * step_nm,
                                  height_nm(&rings, at));
    }
    TEST_ASSERT_EQUAL_INT32(span_nm, height_nm(&rings, turns));
    TEST_ASSERT_EQUAL_INT32(span_nm, height_nm(&rings, turns - 1.0));
}

static void test_height_is_exact_to_a_nanometre(void)
{
    check_heights(200000, 62000000, 2500000, 2000);
    check_heights(100000, 62000000, 4200000, 2000); // ramp nearly half a turn
    check_heights(100000, 62000000, 60000, 2000);   // shortest ramp
    check_heights(10000000, 2000000000, 60000, 1000000);
    check_heights(4, 2000000000, 60000, 1000000);
    check_heights(300001, 1000000, 2500000, 2000); // the last step is shorter
    check_heights(1000000, 1000000, 900000, 2000);
}

/// MATHS.md (40): 0.2 mm of section distance; the ramp moves nothing at whole and half turns.
static void test_worked_heights(void)
{
    static const struct {
        double turns;
        int32_t z_nm;
    } golden[] = {{0.0, 0},      {0.25, 0},     {0.5, 0},      {0.75, 0},
                  {1.0, 0},      {1.5, 100000}, {2.0, 200000}, {2.5, 200000},
                  {3.0, 200000}, {3.5, 300000}, {4.0, 400000}};
    const cam_rings_t rings = cam_feed_rings(200000, 62000000, 1000000, 2000);
    for (size_t i = 0; i < sizeof golden / sizeof golden[0]; i++) {
        TEST_ASSERT_EQUAL_INT32(golden[i].z_nm, height_nm(&rings, golden[i].turns));
    }
    TEST_ASSERT_EQUAL_INT64(INT64_C(621) << 32, cam_feed_turns_q32(&rings));
}

/// Sections nearer than 4 nm do not exist: the longest part has a length that fits.
static void test_turns_of_any_part_fit(void)
{
    const cam_rings_t rings = cam_feed_rings(1, 2000000000, 60000, 2000);
    TEST_ASSERT_EQUAL_INT64((INT64_C(1000000000) + 1) << 32, cam_feed_turns_q32(&rings));
    TEST_ASSERT_EQUAL_INT32(2000000000, height_nm(&rings, 1000000001.0));
}

static void test_early_end_is_behind_a_ring(void)
{
    for (int64_t turns = 1; turns <= 3; turns++) {
        const int64_t end_q32 = (turns | 1) << 32;
        TEST_ASSERT_EQUAL_INT64(end_q32, cam_feed_ring_end_q32(turns << 32));
    }
}
