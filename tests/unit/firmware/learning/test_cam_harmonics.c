// SPDX-License-Identifier: Apache-2.0
// From bins to harmonics and from harmonics to points, against sums in floating point, and the
// numbers of two parts that they are made of.
#include "cam_learning_inner.h" // cam_harmonics_rotated, cam_harmonics_of, cam_harmonics_slew
#include "fixture_random.h"
#include "unity.h"
#include <math.h>
#include <stdlib.h>

#define TURN 6.283185307179586

enum { most_nm = 30000 };

static void test_a_wave_is_its_own_harmonic_and_no_other(void)
{
    static int32_t mean[2 * cam_turn_bins_n]; // a stride of two words
    for (uint32_t k = 0; k <= 16u; k += 5u) {
        for (int i = 0; i < cam_turn_bins_n; i++) {
            const double angle = (i + 0.5) / cam_turn_bins_n * TURN;
            mean[2 * i] = (int32_t)lround(1e8 * cos(k * angle + 0.7));
            mean[2 * i + 1] = 12345;
        }
        for (uint32_t other = 0; other <= 16u; other += 1u) {
            const cam_complex_t c = cam_harmonics_of(mean, 2, other);
            const double re = other == k ? 1e8 * cos(0.7) : 0.0;
            const double im = other == k && k > 0u ? 1e8 * sin(0.7) : 0.0;
            TEST_ASSERT_INT32_WITHIN(8, (int32_t)lround(re), c.re);
            TEST_ASSERT_INT32_WITHIN(8, (int32_t)lround(im), c.im);
        }
    }
}

static void test_points_are_the_sum_of_the_harmonics(void)
{
    static int16_t point[258];
    fixture_random_t random = {.state = 5};
    cam_complex_t c[17];
    for (int k = 0; k <= 16; k++) {
        c[k].re = (int32_t)fixture_random_range(&random, -60000, 60000);
        c[k].im = k > 0 ? (int32_t)fixture_random_range(&random, -60000, 60000) : 0;
    }
    TEST_ASSERT_TRUE(cam_harmonics_slew(point, c, 6, 1 << 17));
    for (int i = 0; i <= 256; i += 3) {
        double sum = 0.0;
        for (int k = 0; k <= 16; k++) {
            sum += c[k].re * cos(TURN * k * i / 256.0) - c[k].im * sin(TURN * k * i / 256.0);
        }
        TEST_ASSERT_INT32_WITHIN(1, (int32_t)lround(sum / 64.0), point[i]);
    }
    TEST_ASSERT_EQUAL_INT16(point[0], point[256]);
}

static void test_points_move_by_no_more_than_a_step_and_arrive(void)
{
    static int16_t point[258];
    static int16_t before[258];
    const cam_complex_t c[17] = {[0] = {.re = 64 * 300}, [3] = {.re = 64 * 500, .im = -64 * 200}};
    bool is_there = false;
    int n = 0;
    for (; !is_there && n < 100; n++) {
        for (int i = 0; i <= 256; i++) {
            before[i] = point[i];
        }
        is_there = cam_harmonics_slew(point, c, 6, 50);
        for (int i = 0; i <= 256; i++) {
            TEST_ASSERT_LESS_OR_EQUAL_INT32(50, abs(point[i] - before[i]));
        }
    }
    TEST_ASSERT_EQUAL_INT32(17, n); // 300 + |500 - 200j| = 838.5 nm in steps of 50
}

static void test_points_beyond_their_word_stay_at_its_end(void)
{
    static int16_t point[258];
    const cam_complex_t c[17] = {[0] = {.re = 64 * most_nm}, [1] = {.re = 64 * most_nm}};
    (void)cam_harmonics_slew(point, c, 6, 1 << 17);
    TEST_ASSERT_EQUAL_INT16(INT16_MAX, point[0]);
    TEST_ASSERT_INT16_WITHIN(1, 0, point[128]);
}

static void test_turned_is_a_multiplication_by_a_unit(void)
{
    const cam_complex_t c = {.re = 100000000, .im = -50000000};
    for (uint32_t k = 1; k <= 16u; k += 3u) {
        const uint32_t angle_q32 = 123456789u * k;
        const double by = TURN * k * angle_q32 / 4294967296.0;
        const cam_complex_t turned = cam_harmonics_rotated(c, k, angle_q32);
        TEST_ASSERT_INT32_WITHIN(9000, (int32_t)lround(1e8 * cos(by) + 5e7 * sin(by)), turned.re);
        TEST_ASSERT_INT32_WITHIN(9000, (int32_t)lround(1e8 * sin(by) - 5e7 * cos(by)), turned.im);
    }
}

/// @return what a part of a harmonic makes of a point, rounded at 2^-5 and as a whole
static int64_t point_by(int64_t part, int64_t cosine, uint32_t down)
{
    const int64_t sum = (part * 128 * cosine + (INT64_C(1) << 31)) >> 32;
    return (sum + (INT64_C(1) << (down + 4u))) >> (down + 5u);
}

/// @return a part of which the point shows whether the cosine is a 2^30th more or less
static int32_t showing_part(int64_t cosine, int64_t other, uint32_t down)
{
    for (int64_t point = 1; point < INT16_MAX; point++) {
        const double sum = ldexp((double)point - 0.5, (int)down + 5);
        const int64_t near = llround(ldexp(sum, 25) / (double)cosine);
        for (int64_t part = near - 1; part <= near + 1; part++) {
            if (point_by(part, cosine, down) != point_by(part, other, down)) {
                TEST_ASSERT_TRUE(llabs(part) < 1 << 23);
                return (int32_t)part;
            }
        }
    }
    TEST_FAIL_MESSAGE("no part shows it");
    return 0;
}

/// On the axes of the circle a 2^30th more or less is rounded away; all other steps show it, at a
/// point that a harmonic makes alone, of its real part or of its imaginary one.
static void test_cosines_are_the_nearest_of_their_word(void)
{
    static int16_t point[258];
    for (uint32_t n = 0; n < 4096u; n++) {
        const uint32_t i = n / 4u % 64u;
        const uint32_t k = 1u + n / 256u;
        const uint32_t step = (k * i + (n & 2u) * 32u) % 256u;
        const int64_t cosine = llround(1073741824.0 * cos(TURN * step / 256.0));
        uint32_t down = 1;
        while (llabs(cosine) >> (down + 7u) >= INT16_MAX) {
            down++;
        }
        if (step % 64u != 0u) {
            const int32_t part = showing_part(cosine, cosine + ((n & 1u) == 0u ? 1 : -1), down);
            cam_complex_t c[17] = {0};
            *((n & 2u) != 0u ? &c[k].im : &c[k].re) = part;
            (void)cam_harmonics_slew(point, c, down, 1 << 17);
            TEST_ASSERT_EQUAL_INT16(point_by(part, cosine, down), point[i]);
        }
    }
}

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
    const cam_complex_t g = {.re = 3 * 4096, .im = -4 * 4096};
    TEST_ASSERT_EQUAL_UINT32(25u << 24, cam_complex_square(g));
}

/// A product is rounded down, and saturated.
static void test_a_number_times_a_gain(void)
{
    for (int i = 0; i < 200; i++) {
        const cam_complex_t a = any(1 << 28);
        const cam_complex_t q12 = any(4 * 4096);
        const cam_complex_t g = {.re = (int16_t)q12.re, .im = (int16_t)q12.im};
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
        const cam_complex_t g = cam_gain_ratio(a, b);
        TEST_ASSERT_DOUBLE_WITHIN(1.01 / 4096.0, fmin(fmax(re, -most), most), g.re / 4096.0);
        TEST_ASSERT_DOUBLE_WITHIN(1.01 / 4096.0, fmin(fmax(im, -most), most), g.im / 4096.0);
    }
    const cam_complex_t none =
        cam_gain_ratio((cam_complex_t){.re = 5, .im = 6}, (cam_complex_t){0});
    TEST_ASSERT_EQUAL_INT16(0, none.re);
    TEST_ASSERT_EQUAL_INT16(0, none.im);
}
