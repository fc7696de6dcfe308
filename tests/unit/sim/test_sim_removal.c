// SPDX-License-Identifier: Apache-2.0
// Known tool paths: a cylinder, the ellipse of MATHS.md (20), equal volume, turns that do not
// count.
#include "fixture_image.h"
#include "sim_removal.h"
#include "sim_units.h" // SIM_PI
#include "unity.h"
#include <math.h>

static sim_removal_t removal;

/// a = 46, depth 0.1: blank 46.1 mm; 3 degrees of a turn of 0.12 s for each slice.
static const sim_removal_config_t papers = {
    .blank_mm = 46.1, .feed_mm = 0.1, .slice_s = 0.001, .kc_n_mm2 = 700.0};

enum { ticks_per_slice = 50, slices_per_turn = 120 };

void setUp(void)
{
    sim_removal_init(&removal, &papers);
}

void tearDown(void) {}

static double ellipse_mm(double turn)
{
    double u[3];
    fixture_ellipse(2.0 * SIM_PI * turn, 0.0, u);
    return 46.0 - u[0] * 1e-6;
}

/// Turn uniformly from an angle on, with one sample every 2 % of a slice.
static int turn_uniformly(double from, double turns, bool is_judged)
{
    const int n = (int)(turns * slices_per_turn * ticks_per_slice + 0.5);
    int n_slices = 0;
    for (int i = 0; i <= n; i++) {
        const double turn = from + (double)i / (slices_per_turn * ticks_per_slice);
        const double t_s = turn * 0.12 + 1e-9 * i / n;
        n_slices +=
            sim_removal_touch(&removal, t_s, turn, 0.1 * turn, ellipse_mm(turn), is_judged) ? 1 : 0;
    }
    return n_slices;
}

static void test_volume_of_a_ring_is_exact(void)
{
    for (int i = 0; i <= 6000; i++) {
        (void)sim_removal_touch(&removal, i * 2e-5, i / 6000.0, 0.1 * i / 6000.0, 46.0, true);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, SIM_PI * (46.1 * 46.1 - 46.0 * 46.0) * 0.1,
                              removal.removed_mm3);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 700.0 * 0.1 * 0.1, sim_spread_mean(&removal.chip_force));
}

/// MATHS.md (29): over 3 degree intervals ripple 0.664244; the chip's section goes 1 : 2.
static void test_ripple_of_uniform_turning_is_the_published_one(void)
{
    TEST_ASSERT_INT_WITHIN(1, 480, turn_uniformly(0.0, 4.0, true));
    TEST_ASSERT_EQUAL_UINT64(2, removal.rate_ripple.n); // the first is half, the last not ended
    TEST_ASSERT_DOUBLE_WITHIN(2e-4, 0.664244, sim_spread_mean(&removal.rate_ripple));
    const double area_mm2 = 4.0 * 10.846348637;
    TEST_ASSERT_DOUBLE_WITHIN(2e-4 * area_mm2, area_mm2 * 0.1 / 0.12,
                              sim_spread_mean(&removal.rate));
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 7.0, removal.chip_force.min);
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 14.0, removal.chip_force.max);
}

static void test_power_and_forces_belong_together(void)
{
    (void)turn_uniformly(0.0, 3.0, true);
    const sim_slice_t *s = &removal.slice;
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.7 * s->rate_mm3_s, s->power_w);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 700.0 * s->volume_mm3 / 0.1, s->rate_force_n);
}

/// Slices of equal volume last equally long, so the rate is even, but the chip force is not.
static void test_equal_volume_has_no_ripple_of_rate_but_of_force(void)
{
    double t_s = 0.0;
    const int n = 4 * slices_per_turn * ticks_per_slice;
    for (int i = 0; i <= n; i++) {
        const double turn = (double)i / (slices_per_turn * ticks_per_slice);
        const double rho = ellipse_mm(turn);
        const double area = (46.1 * 46.1 - rho * rho) / 2.0;
        (void)sim_removal_touch(&removal, t_s, turn, 0.1 * turn, rho, true);
        t_s += area / 6.9 * 2e-5;
    }
    TEST_ASSERT_GREATER_THAN_UINT64(1, removal.rate_ripple.n);
    TEST_ASSERT_TRUE(removal.rate_ripple.max < 3e-3); // samples end a tick, not halve it
    TEST_ASSERT_TRUE(removal.force_ripple.min > 0.6);
}

static void test_turns_that_are_not_judged_do_not_count(void)
{
    (void)turn_uniformly(0.0, 2.5, false);
    TEST_ASSERT_EQUAL_UINT64(0, removal.rate_ripple.n);
    TEST_ASSERT_EQUAL_UINT64(0, removal.rate.n);
    TEST_ASSERT_TRUE(removal.removed_mm3 > 0.0);
    (void)turn_uniformly(2.5, 3.0, true);
    TEST_ASSERT_EQUAL_UINT64(2, removal.rate_ripple.n); // 3 and 4; 2 began unjudged, 5 is not over
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_volume_of_a_ring_is_exact);
    RUN_TEST(test_ripple_of_uniform_turning_is_the_published_one);
    RUN_TEST(test_power_and_forces_belong_together);
    RUN_TEST(test_equal_volume_has_no_ripple_of_rate_but_of_force);
    RUN_TEST(test_turns_that_are_not_judged_do_not_count);
    return UNITY_END();
}
