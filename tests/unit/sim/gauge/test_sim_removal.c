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

static double ellipse_mm(double turn)
{
    double u[3];
    fixture_ellipse(2.0 * SIM_PI * turn, 0.0, u);
    return 46.0 - u[0] * 1e-6;
}

/// Turn uniformly from an angle on, with one sample every 2 % of a slice. The first turn of all
/// cuts thinner chips and is not judged.
static int turn_uniformly(double from, double turns, bool is_judged)
{
    const int n = (int)(turns * slices_per_turn * ticks_per_slice + 0.5);
    int n_slices = 0;
    for (int i = 0; i <= n; i++) {
        const double turn = from + (double)i / (slices_per_turn * ticks_per_slice);
        const double t_s = turn * 0.12 + 1e-9 * i / n;
        const bool is_full = is_judged && turn > 1.0;
        n_slices +=
            sim_removal_touch(&removal, t_s, turn, 0.1 * turn, ellipse_mm(turn), is_full) ? 1 : 0;
    }
    return n_slices;
}

/// Feed from 0.05 turns on over two turns, then turn once more at the same height.
static void test_volume_of_a_ring_is_exact(void)
{
    for (int i = 0; i <= 19000; i++) {
        const double fed = i < 300 ? 0.0 : i < 12300 ? i / 6000.0 - 0.05 : 2.0;
        (void)sim_removal_touch(&removal, i * 2e-5, i / 6000.0, 0.1 * fed, 46.0, i > 6300);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, SIM_PI * (46.1 * 46.1 - 46.0 * 46.0) * 0.2,
                              removal.removed_mm3);
}

/// Z is ahead and behind its helix by 2 um three times a turn, so that its speed changes by a
/// third: every chip is as thick as the feed, because the last pass was ahead and behind there as
/// well.
static void test_z_that_repeats_each_turn_does_not_ripple(void)
{
    for (int i = 0; i <= 6 * 6000; i++) {
        const double turn = i / 6000.0;
        const double z_mm = 0.1 * turn + 0.002 * sin(6.0 * SIM_PI * turn);
        (void)sim_removal_touch(&removal, i * 2e-5, turn, z_mm, 46.0, turn > 1.01);
    }
    TEST_ASSERT_EQUAL_UINT64(3, removal.rate_ripple.n);
    TEST_ASSERT_TRUE(removal.rate_ripple.max < 1e-3);
}

/// F = kc1.1 b h^(1 - mc): b = 0.1 mm, h = 0.1 mm, 700 N/mm2 and mc = 0.25 give 12.448 N, and the
/// power is as much larger than that of a constant 700 N/mm2 as the force. A nose of 0.8 mm cuts
/// 0.1 mm deep along an arc of 0.8 acos(0.875) = 0.404288 mm, so that the chip is 0.0247349 mm
/// thick on average: 700 0.0247349^-0.25 0.01 = 17.6511 N.
static void test_thin_chips_take_more_force_per_area(void)
{
    // Exponent, nose [mm], force [N]
    static const double cases[][3] = {{0.0, 0.0, 7.0}, {0.25, 0.0, 12.448}, {0.25, 0.8, 17.6511}};
    for (int i = 0; i < 3; i++) {
        sim_removal_config_t config = papers;
        config.size_exponent = cases[i][0];
        config.nose_mm = cases[i][1];
        sim_removal_init(&removal, &config);
        for (int k = 0; k <= 18000; k++) { // three turns, judged from the second on
            const double turn = k / 6000.0;
            (void)sim_removal_touch(&removal, k * 2e-5, turn, 0.1 * turn, 46.0, k > 6000);
        }
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, cases[i][2], sim_spread_mean(&removal.chip_force));
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, cases[i][2] / 7.0 * 0.7 * sim_spread_mean(&removal.rate),
                                  sim_spread_mean(&removal.power));
    }
}

/// MATHS.md (29): over 3 degree intervals ripple 0.664244; the chip's section goes 1 : 2.
static void test_ripple_of_uniform_turning_is_the_published_one(void)
{
    TEST_ASSERT_INT_WITHIN(1, 600, turn_uniformly(0.0, 5.0, true));
    TEST_ASSERT_EQUAL_UINT64(3, removal.rate_ripple.n); // 1, 2 and 3: 4 is not over
    TEST_ASSERT_DOUBLE_WITHIN(2e-4, 0.664244, sim_spread_mean(&removal.rate_ripple));
    const double area_mm2 = 4.0 * 10.846348637;
    TEST_ASSERT_DOUBLE_WITHIN(2e-4 * area_mm2, area_mm2 * 0.1 / 0.12,
                              sim_spread_mean(&removal.rate));
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 7.0, removal.chip_force.min);
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 14.0, removal.chip_force.max);
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
    TEST_ASSERT_TRUE(removal.rate_ripple.max < 3e-3);
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
