// SPDX-License-Identifier: Apache-2.0
// Which lobe is played: it changes only while U rests on the base circle, with its phase.
#include "cam_shaft.h"
#include "fixture_shaft.h"
#include "unity.h"
#include <math.h> // fabs, ldexp

#define ONE (INT32_C(1) << 30)

static fixture_image_t image;
static cam_table_t table;
static cam_shaft_t shaft;
static cam_motion_t motion;

void setUp(void)
{
    const fixture_shaft_t three = fixture_shaft_three();
    fixture_shaft_make(&image, &three);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_table_check(image.bytes, image.size, &table));
    shaft = (cam_shaft_t){0};
    motion = (cam_motion_t){.phase_q32 = 1000};
    cam_shaft_begin_isr(&shaft, &table, 0, &motion);
}

static double smooth(double s)
{
    return s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
}

static void test_lift_falls_by_a_smooth_step(void)
{
    for (int32_t i = 0; i <= 1000; i++) {
        const int32_t s_q31 = (int32_t)(INT64_C(2147483647) * i / 1000);
        const cam_share_t share = cam_shaft_share(s_q31, false);
        TEST_ASSERT_TRUE(fabs(ldexp(share.lift_q30, -30) - (1.0 - smooth(i / 1000.0))) < 2e-7);
        TEST_ASSERT_EQUAL_INT32(ONE, share.ratio_q30);
    }
    TEST_ASSERT_EQUAL_INT32(ONE, cam_shaft_share(0, false).lift_q30);
    TEST_ASSERT_EQUAL_INT32(0, cam_shaft_share(INT32_MAX, false).lift_q30);
}

/// One of both always rests.
static void test_speed_ratio_moves_only_while_u_rests(void)
{
    for (int32_t i = 0; i <= 1000; i++) {
        const int32_t s_q31 = (int32_t)(INT64_C(2147483647) * i / 1000);
        const cam_share_t share = cam_shaft_share(s_q31, true);
        TEST_ASSERT_TRUE(share.lift_q30 == 0 || share.ratio_q30 == ONE);
        const double lift = i < 500 ? 1.0 - smooth(i / 500.0) : 0.0;
        const double ratio = i < 500 ? 1.0 : 1.0 - smooth(i / 500.0 - 1.0);
        TEST_ASSERT_TRUE(fabs(ldexp(share.lift_q30, -30) - lift) < 2e-7);
        TEST_ASSERT_TRUE(fabs(ldexp(share.ratio_q30, -30) - ratio) < 2e-7);
    }
    TEST_ASSERT_EQUAL_INT32(0, cam_shaft_share(INT32_MAX, true).ratio_q30);
}

static void test_first_lobe_is_taken_at_the_first_height(void)
{
    TEST_ASSERT_EQUAL_INT32(1000, motion.phase_q32);
    TEST_ASSERT_EQUAL_INT64(INT64_C(0x1FFFFFFFE), motion.height_q32); // pattern 2: all of it
    cam_shaft_begin_isr(&shaft, &table, 700000, &motion);
    TEST_ASSERT_EQUAL_UINT32(2, shaft.i_lobe);
    TEST_ASSERT_EQUAL_INT64(INT64_C(1) << 32, motion.height_q32);
}

static void test_lobe_changes_only_at_amplitude_0(void)
{
    motion.scale_q30 = 5;
    cam_share_t share = cam_shaft_plan_isr(&shaft, &table, 390000, &motion);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(0, shaft.i_lobe, "still on its way down");
    TEST_ASSERT_EQUAL_INT32(0, share.lift_q30);
    TEST_ASSERT_EQUAL_INT32(1000, motion.phase_q32);
    motion.scale_q30 = 0;
    share = cam_shaft_plan_isr(&shaft, &table, 390000, &motion);
    TEST_ASSERT_EQUAL_UINT32(1, shaft.i_lobe);
    TEST_ASSERT_EQUAL_INT32(ONE, share.lift_q30);
    TEST_ASSERT_EQUAL_INT32(1000 + 0x40000000, motion.phase_q32);
    TEST_ASSERT_EQUAL_INT64(0, motion.height_q32);
    (void)cam_shaft_plan_isr(&shaft, &table, 900000, &motion);
    TEST_ASSERT_EQUAL_UINT32(2, shaft.i_lobe);
    TEST_ASSERT_EQUAL_UINT32(0xC0000000u + 1000u, (uint32_t)motion.phase_q32);
}

static void test_table_without_lobes_is_left_alone(void)
{
    const cam_motion_t before = {.phase_q32 = 7, .height_q32 = 99, .scale_q30 = 0};
    table.n_lobes = 0;
    motion = before;
    cam_shaft_begin_isr(&shaft, &table, 500000, &motion);
    const cam_share_t share = cam_shaft_plan_isr(&shaft, &table, 300000, &motion);
    TEST_ASSERT_EQUAL_INT32(ONE, share.lift_q30);
    TEST_ASSERT_EQUAL_INT32(ONE, share.ratio_q30);
    TEST_ASSERT_EQUAL_INT32(7, motion.phase_q32);
    TEST_ASSERT_EQUAL_INT64(99, motion.height_q32);
    TEST_ASSERT_EQUAL_UINT32(0, shaft.phase_q32);
}

/// A ramp without lag, a step of noise as an eighth of it at most, a start within its bound.
static void test_measured_height_is_smoothed(void)
{
    cam_shaft_begin_isr(&shaft, &table, 0, &motion);
    int32_t most_nm = 0;
    for (int32_t i = 1; i <= 400; i++) {
        const int32_t off_nm = 1000 * i - cam_shaft_smooth_isr(&shaft, 1000 * i);
        most_nm = off_nm > most_nm ? off_nm : most_nm;
        TEST_ASSERT_TRUE(i < 200 || (off_nm <= 2 && off_nm >= -2));
    }
    TEST_ASSERT_INT32_WITHIN(100, 5200, most_nm);
    cam_shaft_begin_isr(&shaft, &table, 5000, &motion);
    TEST_ASSERT_INT32_WITHIN(1, 5001, cam_shaft_smooth_isr(&shaft, 5010));
}
