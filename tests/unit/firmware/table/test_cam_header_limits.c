// SPDX-License-Identifier: Apache-2.0
// A table with a speed channel: what is accepted, and every promise that is not kept.
#include "cam_peaks.h"
#include "fixture_image.h"

#include "unity.h"
#include <math.h>

static fixture_image_t image;
static cam_table_t table;
static fixture_part_t part;

void setUp(void)
{
    part = fixture_part_modulated();
    fixture_image_make(&image, &part);
}

static cam_err_t check(void)
{
    fixture_image_seal(&image);
    return cam_table_check(image.bytes, image.size, &table);
}

static cam_err_t with_word(size_t at, uint32_t value)
{
    fixture_image_make(&image, &part);
    fixture_image_put(&image, at, value);
    return check();
}

/// @return result of the check when a promise is lowered by a share of itself
static cam_err_t lowered(size_t at, double share)
{
    const double promised = fixture_image_get(&image, at);
    return with_word(at, (uint32_t)floor(promised * (1.0 - share)));
}

static void test_modulated_table_is_accepted_and_described(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, check());
    TEST_ASSERT_NOT_NULL(table.speed.knots);
    TEST_ASSERT_EQUAL_UINT32(3, table.speed.n_slices);
    TEST_ASSERT_DOUBLE_WITHIN(3e-6, 1.425, table.ratio_max_q20 / (double)CAM_TABLE_RATIO_ONE);
    TEST_ASSERT_DOUBLE_WITHIN(2.0, fixture_image_get(&image, fixture_at_spindle_peak),
                              table.spindle_peak_ppm_per_rad);
}

static void test_uniform_table_has_ratio_one(void)
{
    part = fixture_part_short();
    fixture_image_make(&image, &part);
    TEST_ASSERT_EQUAL_INT(cam_ok, check());
    TEST_ASSERT_NULL(table.speed.knots);
    TEST_ASSERT_EQUAL_UINT32(CAM_TABLE_RATIO_ONE, table.ratio_max_q20);
    TEST_ASSERT_EQUAL_UINT32(0, table.spindle_peak_ppm_per_rad);
    TEST_ASSERT_EQUAL_INT(cam_err_image_limits, with_word(fixture_at_spindle_peak, 1u));
}

static void test_promises_just_kept_pass_and_lower_ones_fail(void)
{
    const size_t at[] = {fixture_at_u1_peak, fixture_at_u2_peak, fixture_at_spindle_peak};
    for (int i = 0; i < 3; i++) {
        fixture_image_make(&image, &part);
        TEST_ASSERT_EQUAL_INT(cam_ok, lowered(at[i], 0.0));
        fixture_image_make(&image, &part);
        TEST_ASSERT_EQUAL_INT(cam_err_image_limits,
                              lowered(at[i], 0.03)); // the check sees the knots only
        TEST_ASSERT_EQUAL_INT(cam_err_image_limits, with_word(at[i], 0u));
    }
}

static void test_speed_outside_a_sixteenth_to_four_is_refused(void)
{
    const int32_t offsets[] = {CAM_TABLE_RATIO_ONE / 4, CAM_TABLE_RATIO_ONE * 4};
    for (int i = 0; i < 2; i++) {
        TEST_ASSERT_EQUAL_INT(cam_err_image_channel,
                              with_word(fixture_image_in(fixture_speed, fixture_in_value_offset),
                                        (uint32_t)offsets[i]));
    }
    TEST_ASSERT_EQUAL_INT(
        cam_err_image_channel,
        with_word(fixture_image_in(fixture_speed, fixture_in_p_max), (uint32_t)CAM_TABLE_SUM_MAX));
}

static void test_second_speed_channel_is_refused(void)
{
    fixture_image_put(&image, fixture_image_in(fixture_u, fixture_in_kind), 3u);
    TEST_ASSERT_NOT_EQUAL_INT(cam_ok, check());
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel,
                          with_word(fixture_image_in(fixture_x, fixture_in_kind), 3u));
}

static void test_absurd_curvature_is_refused_without_overflow(void)
{
    fixture_image_put(&image, fixture_image_in(fixture_u, fixture_in_frac_bits), 0u);
    TEST_ASSERT_NOT_EQUAL_INT(cam_ok, check());
    fixture_image_make(&image, &part);
    cam_knot_t *k = fixture_image_knots(&image, fixture_u);
    for (uint32_t i = 0; i < fixture_image_n_knots(&image, fixture_u); i++) {
        k[i].a *= 1000;
    }
    fixture_image_remeasure(&image, fixture_u);
    TEST_ASSERT_NOT_EQUAL_INT(cam_ok, check());
}

/// Where the spindle is slow, U's acceleration is small whatever the curvature: the limit of the
/// curvature itself, 2^40 nm per turn^2, refuses a table that no promise does.
static void test_curvature_is_limited_by_itself(void)
{
    enum { n_u = 32, n_speed = 8 };
    static cam_knot_t u[n_u], speed[n_speed];
    cam_table_t t = {.u = {.knots = u, .n_slices = 2, .log2_knots = 4, .log2_repeat = 4},
                     .speed = {.knots = speed,
                               .n_slices = 2,
                               .log2_knots = 2,
                               .value_offset = CAM_TABLE_RATIO_ONE / 8},
                     .u1_peak_nm_per_rad = INT32_MAX,
                     .u2_peak_nm_per_rad2 = INT32_MAX};
    t.u.span_nm = t.speed.span_nm = 1000000;
    t.u.slices_per_nm_q48 = t.speed.slices_per_nm_q48 = 281474977;
    for (int sign = -1; sign <= 1; sign += 2) {
        u[n_u - 1].a = sign * (1 << 23);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_peaks_check(&t));
        u[n_u - 1].a += sign;
        TEST_ASSERT_EQUAL_INT(cam_err_image_limits, cam_peaks_check(&t));
    }
}
