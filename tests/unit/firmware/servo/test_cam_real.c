// SPDX-License-Identifier: Apache-2.0
// Against double precision, over numbers of 30 decades.
#include "cam_real.h"
#include "fixture_random.h"
#include "unity.h"
#include <math.h>    // fabs, ldexp, sqrt
#include <stdbool.h> // bool

#define RELATIVE 1e-9 // 2^-30

static double of(cam_real_t a)
{
    return ldexp(a.m, a.e);
}

static void expect(double right, cam_real_t found, double scale)
{
    TEST_ASSERT_TRUE(fabs(of(found) - right) <= RELATIVE * scale);
    TEST_ASSERT_TRUE(found.m == 0u || found.m >= UINT32_C(1) << 31);
}

static cam_real_t any(fixture_random_t *dice)
{
    const uint64_t m = (uint64_t)fixture_random_range(dice, 1, INT64_MAX - 1);
    return cam_real_scaled(m, (int32_t)fixture_random_range(dice, -100, 40));
}

static void test_operations_round_by_a_thousand_millionth(void)
{
    fixture_random_t dice = {.state = 5};
    for (int i = 0; i < 20000; i++) {
        const cam_real_t a = any(&dice);
        const cam_real_t b = any(&dice);
        expect(of(a) * of(b), cam_real_times(a, b), of(a) * of(b));
        expect(of(a) / of(b), cam_real_over(a, b), of(a) / of(b));
        expect(of(a) + of(b), cam_real_plus(a, b), of(a) + of(b));
        expect(sqrt(of(a)), cam_real_root(a), sqrt(of(a)));
        const bool is_less = of(b) <= of(a);
        expect(fabs(of(a) - of(b)), is_less ? cam_real_minus(a, b) : cam_real_minus(b, a),
               of(a) + of(b));
    }
}

static void test_nothing_is_a_number(void)
{
    const cam_real_t none = cam_real(0);
    const cam_real_t five = cam_real(5);
    expect(0.0, cam_real_times(none, five), 1.0);
    expect(0.0, cam_real_over(none, five), 1.0);
    expect(5.0, cam_real_plus(none, five), 1.0);
    expect(5.0, cam_real_plus(five, none), 1.0);
    expect(5.0, cam_real_minus(five, none), 1.0);
    expect(0.0, cam_real_minus(five, five), 1.0);
    expect(0.0, cam_real_root(none), 1.0);
    TEST_ASSERT_EQUAL_INT64(0, cam_real_to_q(none, 30));
}

static void test_fixed_point_is_rounded_to_nearest(void)
{
    TEST_ASSERT_EQUAL_INT64(5 << 20, cam_real_to_q(cam_real(5), 20));
    TEST_ASSERT_EQUAL_INT64(3, cam_real_to_q(cam_real_over(cam_real(11), cam_real(4)), 0));
    TEST_ASSERT_EQUAL_INT64(2, cam_real_to_q(cam_real_over(cam_real(9), cam_real(4)), 0));
    TEST_ASSERT_EQUAL_INT64(1, cam_real_to_q(cam_real_scaled(1, -1), 0));
    TEST_ASSERT_EQUAL_INT64(0, cam_real_to_q(cam_real_scaled(UINT64_MAX, -65), 0));
    TEST_ASSERT_EQUAL_INT64(0, cam_real_to_q(cam_real_scaled(1, -90), 3));
    TEST_ASSERT_EQUAL_INT64(INT64_C(1) << 61, cam_real_to_q(cam_real(1), 61));
    TEST_ASSERT_EQUAL_INT64(INT64_C(1) << 62, cam_real_to_q(cam_real(1), 62));
    TEST_ASSERT_EQUAL_INT64(INT64_C(1) << 62, cam_real_to_q(cam_real_scaled(1, 1000), 62));
    TEST_ASSERT_EQUAL_INT64(3373259426, cam_real_to_q(CAM_REAL_PI, 30));
}
