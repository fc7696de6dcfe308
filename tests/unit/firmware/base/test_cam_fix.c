// SPDX-License-Identifier: Apache-2.0
// Fixed-point operations against plain arithmetic of 64 bits, at the ends of their ranges above
// all.
#include "cam_fix.h"
#include "unity.h"

static const int32_t ends[] = {
    INT32_MIN, INT32_MIN + 1, -1073741825, -123456789, -65536,        -32769,   -2, -1, 0, 1, 2, 3,
    32767,     65535,         123456789,   1073741824, INT32_MAX - 1, INT32_MAX};
enum { n_ends = sizeof ends / sizeof ends[0] };

/// @return v / 2^n rounded down
static int64_t floor_of(int64_t v, uint32_t n)
{
    const int64_t by = INT64_C(1) << n;
    return v / by - (v % by < 0 ? 1 : 0);
}

static int32_t wrapped(int64_t v)
{
    return (int32_t)(uint32_t)(uint64_t)v;
}

static int64_t limited(int64_t v)
{
    return v < INT32_MIN ? INT32_MIN : v > INT32_MAX ? INT32_MAX : v;
}

/// Two words of the list, whatever their sum and product may be.
static void expect_pair(int32_t a, int32_t b)
{
    const int64_t product = (int64_t)a * b;
    const int64_t part = floor_of(product + (INT64_C(1) << 31), 32);
    TEST_ASSERT_EQUAL_INT32(part, cam_mulhi(a, b));
    for (int i = 0; i < n_ends; i++) {
        TEST_ASSERT_EQUAL_INT32(wrapped(ends[i] + part), cam_mulhi_add(ends[i], a, b));
    }
    TEST_ASSERT_EQUAL_INT32(limited((int64_t)a + b), cam_sat_add(a, b));
    TEST_ASSERT_EQUAL_INT32(limited((int64_t)a - b), cam_sat_sub(a, b));
    TEST_ASSERT_EQUAL_INT32(wrapped((int64_t)a + b), cam_wrap_add(a, b));
    TEST_ASSERT_EQUAL_INT32(wrapped((int64_t)a - b), cam_wrap_sub(a, b));
    TEST_ASSERT_EQUAL_INT32(wrapped((int64_t)a - b), cam_wrap_diff((uint32_t)a, (uint32_t)b));
    TEST_ASSERT_EQUAL_INT64((int64_t)a + b, cam_wrap_add_i64(a, b));
    TEST_ASSERT_EQUAL_INT64((int64_t)a - b, cam_wrap_sub_i64(a, b));
    TEST_ASSERT_EQUAL_INT64(product, cam_wrap_times_i64(a, b));
    const uint64_t whole = (uint64_t)(uint32_t)a * (uint32_t)b;
    TEST_ASSERT_EQUAL_HEX32(whole / (UINT64_C(1) << 32), cam_mulhi_u32((uint32_t)a, (uint32_t)b));
    if (b >= 0) {
        TEST_ASSERT_EQUAL_INT32(wrapped(product), cam_wrap_times(a, (uint32_t)b));
        const bool is_in = a >= -(int64_t)b && a <= b;
        TEST_ASSERT_EQUAL_INT(is_in, cam_is_within(a, b));
    }
}

static void test_pairs_of_words_are_what_wide_arithmetic_makes_of_them(void)
{
    for (int i = 0; i < n_ends; i++) {
        for (int k = 0; k < n_ends; k++) {
            expect_pair(ends[i], ends[k]);
        }
    }
}

static void test_wide_sums_and_products_wrap(void)
{
    TEST_ASSERT_EQUAL_INT64(INT64_MIN, cam_wrap_add_i64(INT64_MAX, 1));
    TEST_ASSERT_EQUAL_INT64(INT64_MAX, cam_wrap_sub_i64(INT64_MIN, 1));
    TEST_ASSERT_EQUAL_INT64(-2, cam_wrap_times_i64(INT64_MAX, 2));
}

static void test_symmetric_range_ends_where_it_says(void)
{
    for (int32_t limit = 0; limit < 5; limit++) {
        for (int32_t v = -6; v <= 6; v++) {
            TEST_ASSERT_EQUAL_INT(v >= -limit && v <= limit, cam_is_within(v, limit));
        }
    }
    TEST_ASSERT_TRUE(cam_is_within(-INT32_MAX, INT32_MAX));
    TEST_ASSERT_FALSE(cam_is_within(INT32_MIN, INT32_MAX));
}

static void test_half_words_are_multiplied_with_their_signs(void)
{
    static const int16_t halves[] = {INT16_MIN, -12345, -1, 0, 1, 2, 12345, INT16_MAX};
    for (int i = 0; i < 8 * 8 * 8 * 8; i++) {
        const int16_t al = halves[i % 8];
        const int16_t ah = halves[i / 8 % 8];
        const int16_t bl = halves[i / 64 % 8];
        const int16_t bh = halves[i / 512];
        const uint32_t a = (uint32_t)(uint16_t)ah << 16 | (uint16_t)al;
        const uint32_t b = (uint32_t)(uint16_t)bh << 16 | (uint16_t)bl;
        const int64_t sum = (int64_t)al * bl + (int64_t)ah * bh;
        TEST_ASSERT_EQUAL_INT32(wrapped(sum), cam_dot_i16(a, b));
    }
}

static void test_product_is_shifted_with_rounding_half_up(void)
{
    for (int32_t a = -40; a <= 40; a++) {
        for (uint32_t n = 1; n <= 6u; n++) {
            const int64_t half = INT64_C(1) << (n - 1u);
            TEST_ASSERT_EQUAL_INT32(floor_of(3 * a + half, n), cam_mul_shift(a, 3, n));
        }
    }
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, cam_mul_shift(INT32_MAX, 1 << 30, 30));
    TEST_ASSERT_EQUAL_INT32(1, cam_mul_shift(INT32_MIN, INT32_MIN, 62));
    TEST_ASSERT_EQUAL_INT32(-1, cam_mul_shift(INT32_MIN, INT32_MAX, 62));
}

static void test_wide_shift_keeps_the_low_word_of_the_floor(void)
{
    for (int i = 0; i < n_ends; i++) {
        const int64_t v = (int64_t)ends[i] * 1234567;
        for (uint32_t n = 1; n <= 31u; n++) {
            TEST_ASSERT_EQUAL_INT32(wrapped(floor_of(v, n)), cam_shift_right(v, n));
        }
    }
}

static void test_limits_are_kept_and_reached(void)
{
    for (int32_t v = -5; v <= 5; v++) {
        const int32_t held = v < -2 ? -2 : v > 3 ? 3 : v;
        TEST_ASSERT_EQUAL_INT32(held, cam_clamp_i32(v, -2, 3));
        TEST_ASSERT_EQUAL_INT64(held, cam_clamp_i64(v, -2, 3));
        TEST_ASSERT_EQUAL_INT(held == v, cam_is_between(v, -2, 3));
        TEST_ASSERT_EQUAL_INT64(v < 0 ? -v : v, cam_abs_i64(v));
    }
    TEST_ASSERT_EQUAL_INT64(INT64_MAX, cam_abs_i64(-INT64_MAX));
    for (int64_t off = -2; off <= 2; off++) {
        TEST_ASSERT_EQUAL_INT32(limited(INT32_MAX + off), cam_sat_i32(INT32_MAX + off));
        TEST_ASSERT_EQUAL_INT32(limited(INT32_MIN + off), cam_sat_i32(INT32_MIN + off));
    }
    TEST_ASSERT_EQUAL_INT32(0, cam_sat_i32(0));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, cam_sat_i32(INT64_C(1) << 32));
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, cam_sat_i32(-(INT64_C(1) << 32)));
}

static void test_quotients_are_rounded_up(void)
{
    static const uint64_t fifths[] = {0, 1, 1, 1, 1, 1, 2};
    for (uint64_t a = 0; a < 7u; a++) {
        TEST_ASSERT_EQUAL_UINT64(fifths[a], cam_divided_up_u64(a, 5));
        TEST_ASSERT_EQUAL_UINT64(fifths[a], cam_scaled_up_u64(a, 2, 10));
    }
    TEST_ASSERT_EQUAL_UINT64(0, cam_scaled_up_u64(0, UINT64_MAX, 1));
    TEST_ASSERT_EQUAL_UINT64(INT64_MAX, cam_scaled_up_u64(UINT64_C(1) << 32, UINT64_C(1) << 32, 9));
}

static void test_smaller_and_greater_of_two(void)
{
    TEST_ASSERT_EQUAL_INT64(-2, cam_smaller_i64(-2, 1));
    TEST_ASSERT_EQUAL_INT64(-2, cam_smaller_i64(1, -2));
    TEST_ASSERT_EQUAL_UINT64(7, cam_greater_u64(7, 3));
    TEST_ASSERT_EQUAL_UINT64(7, cam_greater_u64(3, 7));
}

static void test_root_is_rounded_down(void)
{
    for (uint64_t r = 0; r < 70u; r++) {
        TEST_ASSERT_EQUAL_UINT64(r, cam_root_u64(r * r));
        TEST_ASSERT_EQUAL_UINT64(r, cam_root_u64(r * r + 2u * r));
    }
    const uint64_t most = UINT32_MAX;
    TEST_ASSERT_EQUAL_UINT64(most, cam_root_u64(UINT64_MAX));
    TEST_ASSERT_EQUAL_UINT64(most, cam_root_u64(most * most));
    TEST_ASSERT_EQUAL_UINT64(most - 1u, cam_root_u64(most * most - 1u));
}

/// By 2 pi, rounded down by less than 4e-7 and 1.
static void test_derivative_per_turn_becomes_one_per_rad(void)
{
    for (int64_t x = 0; x < INT64_C(1) << 41; x += 1 + x / 9) {
        const double exact = (double)x / 6.283185307179586;
        const double found = (double)cam_per_rad(x);
        TEST_ASSERT_TRUE(found <= exact && found > exact * (1.0 - 4e-7) - 1.0);
    }
}
