// SPDX-License-Identifier: Apache-2.0
#include "cam_doubles.h"
#include "unity.h"

static void test_halves_are_rounded_away_from_zero(void)
{
    static const struct {
        double v;
        int64_t nearest;
    } cases[] = {
        {0.0, 0},
        {0.49999999999999994, 0},
        {0.5, 1},
        {-0.49999999999999994, 0},
        {-0.5, -1},
        {1.5, 2},
        {-2.5, -3},
        {4503599627370495.5, 4503599627370496},
        {9007199254740993.0, 9007199254740992}, // the double before it
        {-0x1p63, INT64_MIN},
        {-0x1.0000000000001p63, INT64_MIN},
        {0x1p63, INT64_MAX},
        {1e300, INT64_MAX},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        TEST_ASSERT_EQUAL_INT64(cases[i].nearest, cam_nearest_i64(cases[i].v));
    }
}

static void test_words_saturate(void)
{
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, cam_nearest(2147483647.4));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, cam_nearest(2147483647.5));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, cam_nearest(1e300));
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, cam_nearest(-2147483648.5));
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, cam_nearest(-1e300));
    TEST_ASSERT_EQUAL_INT32(-2147483647, cam_nearest(-2147483647.4));
}

static void test_root_is_rounded_to_nearest(void)
{
    static const volatile double tenth = 0.1;
    TEST_ASSERT_TRUE(cam_root(2.0) == 0x1.6a09e667f3bcdp0);
    TEST_ASSERT_TRUE(cam_root(tenth) == 0x1.43d136248490fp-2);
    TEST_ASSERT_TRUE(cam_root(0.0) == 0.0);
    TEST_ASSERT_TRUE(cam_root(0x1p-1000) == 0x1p-500);
}
