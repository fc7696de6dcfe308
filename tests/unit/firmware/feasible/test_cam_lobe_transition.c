// SPDX-License-Identifier: Apache-2.0
// What an axis needs between two lobes, against the largest sum on a grid of a thousandth.
#include "cam_z_coupling.h"
#include "fixture_random.h"
#include "unity.h"
#include <math.h> // fabs, fmax, ldexp

#define TWO_PI 6.283185307179586

static const cam_knot_t knot;

/// Largest needs, by the equations.
static void exact(const cam_table_t *t, double feed_nm, const cam_z_coupling_peaks_t *p, double n,
                  double most[2])
{
    const double half = t->speed.knots != NULL ? 0.5 : 1.0;
    const double x = ldexp(t->ratio_max_q20, -20) * feed_nm / (TWO_PI * t->least_change_nm * half);
    const double spindle = t->spindle_peak_ppm_per_rad * 1e-6;
    most[0] = most[1] = 0.0;
    for (int i = 0; i <= 1000; i++) {
        const double s = i / 1000.0;
        const double e = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
        const double e1 = 30.0 * s * s * (1.0 - s) * (1.0 - s);
        const double e2 = fabs(60.0 * s * (1.0 - s) * (1.0 - 2.0 * s));
        most[0] = fmax(most[0], e * (double)p->f1 + e1 * (double)p->f * x);
        most[1] = fmax(most[1], e * (double)p->f2 +
                                    e1 * x * (2.0 * (double)p->f1 + n * (double)p->f * spindle) +
                                    n * e2 * (double)p->f * x * x);
    }
}

/// A bound is never below, and above only by what the grid of twentieths costs.
static void test_needs_are_bounded_tightly(void)
{
    fixture_random_t random = {87u};
    for (int k = 0; k < 2000 / fixture_rarer; k++) {
        const cam_table_t t = {
            .least_change_nm = (uint32_t)fixture_random_range(&random, 80000, 40000000),
            .ratio_max_q20 = (uint32_t)fixture_random_range(&random, 1 << 20, 4 << 20),
            .spindle_peak_ppm_per_rad = (uint32_t)fixture_random_range(&random, 0, 10000000),
            .speed.knots = k % 2 == 0 ? NULL : &knot,
        };
        const uint64_t feed_nm = (uint64_t)fixture_random_range(&random, 1000, 3000000);
        const cam_z_coupling_peaks_t p = {
            (uint64_t)fixture_random_range(&random, 1000000, 15000000),
            (uint64_t)fixture_random_range(&random, 1000000, 60000000),
            (uint64_t)fixture_random_range(&random, 10000000, 900000000)};
        double most[2];
        const uint32_t n = 1u + (uint32_t)k % 8u;
        exact(&t, (double)feed_nm, &p, n, most);
        const double first = (double)cam_z_coupling_lobes_first(&t, feed_nm, &p);
        const double second = (double)cam_z_coupling_lobes_second(&t, feed_nm, &p, n);
        TEST_ASSERT_TRUE(first >= most[0] * (1.0 - 1e-6) && first <= most[0] * 1.09 + 10.0);
        TEST_ASSERT_TRUE(second >= most[1] * (1.0 - 1e-6) && second <= most[1] * 1.12 + 10.0);
        TEST_ASSERT_TRUE(first >= (double)p.f1 && second >= (double)p.f2);
    }
}

static void test_needs_rise_with_the_feed_and_vanish_without_a_change(void)
{
    cam_table_t t = {.least_change_nm = 100000, .ratio_max_q20 = 1u << 20};
    const cam_z_coupling_peaks_t p = {8000000u, 12000000u, 40000000u};
    uint64_t before = 0;
    for (uint64_t feed_nm = 1; feed_nm < UINT64_C(1) << 24; feed_nm = feed_nm * 5u / 4u + 1u) {
        const uint64_t second = cam_z_coupling_lobes_second(&t, feed_nm, &p, 8u);
        TEST_ASSERT_TRUE(second >= before);
        before = second;
    }
    t.least_change_nm = 0;
    TEST_ASSERT_EQUAL_UINT64(p.f1, cam_z_coupling_lobes_first(&t, 100000, &p));
    TEST_ASSERT_EQUAL_UINT64(p.f2, cam_z_coupling_lobes_second(&t, 100000, &p, 8u));
}

/// A change over next to nothing needs no more than is told of the steepest: numbers stay in their
/// words.
static void test_needs_of_the_steepest_change_are_bounded(void)
{
    const cam_z_coupling_peaks_t p = {8000000u, 12000000u, 40000000u};
    cam_table_t t = {.least_change_nm = 1, .ratio_max_q20 = 4u << 20};
    const uint64_t first = cam_z_coupling_lobes_first(&t, 1u << 24, &p);
    const uint64_t second = cam_z_coupling_lobes_second(&t, 1u << 24, &p, 80u);
    t.least_change_nm = 3;
    TEST_ASSERT_EQUAL_UINT64(first, cam_z_coupling_lobes_first(&t, 1u << 24, &p));
    TEST_ASSERT_EQUAL_UINT64(second, cam_z_coupling_lobes_second(&t, 1u << 24, &p, 80u));
    TEST_ASSERT_TRUE(first <= p.f1 + 2u * p.f * 34u && first > p.f * 60u); // 2^25 ppm, 15 / 8
}
