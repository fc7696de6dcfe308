// SPDX-License-Identifier: Apache-2.0
// Numbers of two parts, against doubles; what their words cannot hold is limited.
#include "cam_learning_inner.h" // cam_complex_t, cam_gain_t, cam_complex_add, cam_complex_size
#include "fixture_random.h"
#include "unity.h"
#include <math.h>

static fixture_random_t random_of;

void setUp(void)
{
    random_of = (fixture_random_t){3u};
}

static cam_complex_t any(int32_t most)
{
    return (cam_complex_t){.re = (int32_t)fixture_random_range(&random_of, -most, most),
                           .im = (int32_t)fixture_random_range(&random_of, -most, most)};
}

static void test_sums_and_magnitudes(void)
{
    const cam_complex_t a = {.re = 3, .im = -4};
    const cam_complex_t b = {.re = -10, .im = 7};
    TEST_ASSERT_EQUAL_INT32(-7, cam_complex_add(a, b).re);
    TEST_ASSERT_EQUAL_INT32(3, cam_complex_add(a, b).im);
    TEST_ASSERT_EQUAL_INT32(13, cam_complex_sub(a, b).re);
    TEST_ASSERT_EQUAL_INT32(-11, cam_complex_sub(a, b).im);
    TEST_ASSERT_EQUAL_UINT64(25, cam_complex_square(a));
    TEST_ASSERT_EQUAL_UINT32(5, cam_complex_size(a));
    TEST_ASSERT_EQUAL_UINT32(12, cam_complex_size(b)); // 12.2, rounded down
    const cam_complex_t largest = {.re = INT32_MIN, .im = INT32_MIN};
    TEST_ASSERT_EQUAL_UINT64(UINT64_C(1) << 63, cam_complex_square(largest));
    TEST_ASSERT_EQUAL_UINT32(3037000499u, cam_complex_size(largest));
    const cam_gain_t g = {.re_q12 = 3 * 4096, .im_q12 = -4 * 4096};
    TEST_ASSERT_EQUAL_UINT32(25u << 24, cam_gain_square_q24(g));
}

/// A product is rounded down, and saturated.
static void test_a_number_times_a_gain(void)
{
    for (int i = 0; i < 200; i++) {
        const cam_complex_t a = any(1 << 28);
        const cam_complex_t q12 = any(4 * 4096);
        const cam_gain_t g = {.re_q12 = (int16_t)q12.re, .im_q12 = (int16_t)q12.im};
        const double re = ((double)a.re * q12.re - (double)a.im * q12.im) / 4096.0;
        const double im = ((double)a.re * q12.im + (double)a.im * q12.re) / 4096.0;
        const cam_complex_t product = cam_gain_of(a, g);
        const double most = INT32_MAX;
        TEST_ASSERT_DOUBLE_WITHIN(1.0, fmin(fmax(floor(re), -most - 1.0), most), product.re);
        TEST_ASSERT_DOUBLE_WITHIN(1.0, fmin(fmax(floor(im), -most - 1.0), most), product.im);
    }
}

/// A ratio of small and of large numbers has the same error, and stays within 8.
static void test_a_ratio_is_a_gain(void)
{
    static const int32_t sizes[] = {1000, 1 << 20, 1 << 25, 1 << 30};
    for (int i = 0; i < 400; i++) {
        const cam_complex_t a = any(sizes[i % 4]);
        const cam_complex_t b = any(sizes[i / 4 % 4]);
        const double square = (double)b.re * b.re + (double)b.im * b.im;
        if (square < 100.0) {
            continue;
        }
        const double re = ((double)a.re * b.re + (double)a.im * b.im) / square;
        const double im = ((double)a.im * b.re - (double)a.re * b.im) / square;
        const double most = INT16_MAX / 4096.0;
        const cam_gain_t g = cam_gain_ratio(a, b);
        TEST_ASSERT_DOUBLE_WITHIN(1.01 / 4096.0, fmin(fmax(re, -most), most), g.re_q12 / 4096.0);
        TEST_ASSERT_DOUBLE_WITHIN(1.01 / 4096.0, fmin(fmax(im, -most), most), g.im_q12 / 4096.0);
    }
    const cam_gain_t none = cam_gain_ratio((cam_complex_t){.re = 5, .im = 6}, (cam_complex_t){0});
    TEST_ASSERT_EQUAL_INT16(0, none.re_q12);
    TEST_ASSERT_EQUAL_INT16(0, none.im_q12);
}
