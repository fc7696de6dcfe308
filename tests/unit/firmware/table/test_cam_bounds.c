// SPDX-License-Identifier: Apache-2.0
// Bounds of a quintic between two knots, against its Bernstein coefficients and a fine grid.
#include "cam_table_inner.h" // cam_bounds_next, cam_bounds_add, cam_bounds_add_second
#include "fixture_random.h"
#include "unity.h"
#include <math.h>

static double c[6]; ///< coefficients of the quintic
static cam_wide_knot_t k0, k1;

/// Knots of a quintic with whole coefficients.
static void segment(int64_t p, int64_t v, int64_t a, int64_t c3, int64_t c4, int64_t c5)
{
    const int64_t whole[] = {p, v, a, c3, c4, c5};
    for (int i = 0; i < 6; i++) {
        c[i] = (double)whole[i];
    }
    k0 = (cam_wide_knot_t){p, v, a};
    k1 = (cam_wide_knot_t){p + v + a + c3 + c4 + c5, v + 2 * a + 3 * c3 + 4 * c4 + 5 * c5,
                           a + 3 * c3 + 6 * c4 + 10 * c5};
}

static double choose(int n, int k)
{
    double made = 1.0;
    for (int i = 0; i < k; i++) {
        made = made * (n - i) / (i + 1);
    }
    return made;
}

/// @return the largest Bernstein coefficient of a polynomial, but for the last, which is the first
/// of the next segment
static double largest(const double *of, int degree)
{
    double most = 0.0;
    for (int j = 0; j < degree; j++) {
        double sum = 0.0;
        for (int i = 0; i <= j; i++) {
            sum += choose(j, i) / choose(degree, i) * of[i];
        }
        most = fmax(most, fabs(sum));
    }
    return most;
}

static void test_value_and_slope_are_bounded_by_their_coefficients(void)
{
    fixture_random_t random = {5u};
    cam_bounds_t all = {0};
    double most[2] = {0.0, 0.0};
    for (int i = 0; i < 500; i++) {
        int64_t r[6];
        for (int k = 0; k < 6; k++) {
            const int32_t wide = (i + k) % 3 == 0 ? 1000000 : 1000; // another one leads in turn
            r[k] = fixture_random_range(&random, -wide, wide);
        }
        segment(r[0], r[1], r[2], r[3], r[4], r[5]);
        const double slope[] = {c[1], 2.0 * c[2], 3.0 * c[3], 4.0 * c[4], 5.0 * c[5]};
        cam_bounds_t b = {0};
        cam_bounds_add(&b, &k0, &k1);
        TEST_ASSERT_EQUAL_INT64(llround(10.0 * largest(c, 5)), b.tenfold);
        TEST_ASSERT_EQUAL_INT64(llround(2.0 * largest(slope, 4)), b.twice);
        TEST_ASSERT_EQUAL_INT64(0, b.second_8192);
        most[0] = fmax(most[0], (double)b.tenfold);
        most[1] = fmax(most[1], (double)b.twice);
        cam_bounds_add(&all, &k0, &k1); // bounds widen, and never shrink
        TEST_ASSERT_EQUAL_INT64((int64_t)most[0], all.tenfold);
        TEST_ASSERT_EQUAL_INT64((int64_t)most[1], all.twice);
    }
}

/// Each term alone is largest at an end of the segment, where nothing is lost; what the curve may
/// do between two places of the grid is a 8192nd of the fourth derivative there.
static void test_each_term_of_the_second_derivative_counts(void)
{
    static const struct {
        int64_t a, c3, c4, c5, bound;
    } cases[] = {
        {1000, 0, 0, 0, 2 * 8192},
        {0, 1000, 0, 0, 6 * 8192},
        {0, 0, 1000, 0, 12 * 8192 + 24},
        {0, 0, 0, 1000, 20 * 8192 + 120},
        {0, 0, 5000, -1000, (60 - 20) * 8192 + 120}, // the bend is largest at the begin
        {0, 0, -1000, 2000, (40 - 12) * 8192 + 216}, // ... and here at the end
    };
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        for (int64_t sign = -1; sign <= 1; sign += 2) {
            cam_bounds_t b = {0};
            segment(7, 11, sign * cases[i].a, sign * cases[i].c3, sign * cases[i].c4,
                    sign * cases[i].c5);
            cam_bounds_add_second(&b, &k0, &k1);
            TEST_ASSERT_EQUAL_INT64(1000 * cases[i].bound, b.second_8192);
        }
    }
}

/// Never below the true maximum, and within a hundredth above it.
static void test_second_derivative_is_bounded_within_a_hundredth(void)
{
    fixture_random_t random = {6u};
    for (int i = 0; i < 200 / fixture_rarer; i++) {
        int64_t r[4];
        for (int k = 0; k < 4; k++) {
            r[k] = fixture_random_range(&random, -100000, 100000);
        }
        segment(0, 0, r[0], r[1], r[2], r[3]);
        double most = 0.0;
        for (int k = 0; k <= 1000; k++) {
            const double t = k / 1000.0;
            most = fmax(most,
                        fabs(2.0 * c[2] + t * (6.0 * c[3] + t * (12.0 * c[4] + t * 20.0 * c[5]))));
        }
        cam_bounds_t b = {0};
        cam_bounds_add_second(&b, &k0, &k1);
        const double found = (double)b.second_8192 / 8192.0;
        TEST_ASSERT_TRUE(found >= most * (1.0 - 1e-5) && found <= most * 1.01);
    }
}

/// Behind the last knot of a slice comes its first one.
static void test_next_knot_is_of_the_same_slice(void)
{
    const cam_channel_t ch = {.log2_knots = 3, .n_slices = 4};
    TEST_ASSERT_EQUAL_UINT32(1, cam_bounds_next(&ch, 0));
    TEST_ASSERT_EQUAL_UINT32(0, cam_bounds_next(&ch, 7));
    TEST_ASSERT_EQUAL_UINT32(9, cam_bounds_next(&ch, 8));
    TEST_ASSERT_EQUAL_UINT32(15, cam_bounds_next(&ch, 14));
    TEST_ASSERT_EQUAL_UINT32(24, cam_bounds_next(&ch, 31));
}
