// SPDX-License-Identifier: Apache-2.0
#include "cam_doubles.h"
#include "unity.h"

static void test_halves_are_rounded_away_from_zero_and_words_saturate(void)
{
    const double not_a_number = __builtin_nan("");
    const struct {
        double v;
        int32_t nearest;
    } cases[] = {
        {0.0, 0},
        {0.4999999, 0},
        {0.5, 1},
        {-0.4999999, 0},
        {-0.5, -1},
        {-2.5, -3},
        {2147483646.5, INT32_MAX},
        {2147483647.5, INT32_MAX},
        {1e300, INT32_MAX},
        {-2147483647.4, -INT32_MAX},
        {-2147483647.5, INT32_MIN},
        {-2147483648.5, INT32_MIN},
        {-1e300, INT32_MIN},
        {not_a_number, INT32_MIN},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        TEST_ASSERT_EQUAL_INT32(cases[i].nearest, cam_nearest(cases[i].v));
    }
}

static void test_a_limit_holds_for_any_number(void)
{
    static const struct {
        double v, limited;
    } cases[] = {{-3.0, -2.0}, {-2.0, -2.0}, {1.5, 1.5}, {2.0, 2.0}, {3.0, 2.0}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        TEST_ASSERT_TRUE(cam_limit(cases[i].v, 2.0) == cases[i].limited);
    }
    TEST_ASSERT_TRUE(cam_limit(__builtin_nan(""), 2.0) == -2.0);
}

static void test_root_is_rounded_to_nearest(void)
{
    static const volatile double tenth = 0.1;
    TEST_ASSERT_TRUE(cam_root(2.0) == 0x1.6a09e667f3bcdp0);
    TEST_ASSERT_TRUE(cam_root(tenth) == 0x1.43d136248490fp-2);
    TEST_ASSERT_TRUE(cam_root(0.0) == 0.0);
    TEST_ASSERT_TRUE(cam_root(0x1p-1000) == 0x1p-500);
}
