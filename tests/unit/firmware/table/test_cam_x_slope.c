// SPDX-License-Identifier: Apache-2.0
// Slope and bend of X's profile against the derivatives that the table was made of.
#include "fixture_image.h"
#include "unity.h"

static fixture_image_t image;
static cam_table_t table;
static fixture_part_t part;

void setUp(void)
{
    part = fixture_part_short();
}

static void make(void)
{
    fixture_image_make(&image, &part);
    fixture_image_seal(&image);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_table_check(image.bytes, image.size, &table));
}

/// The profile is steepest at the upper end, 600 000 nm from the largest radius.
static void test_parabola_has_its_peaks_at_its_end(void)
{
    make();
    TEST_ASSERT_UINT32_WITHIN(20, 24000, table.x_slope_ppm);
    TEST_ASSERT_UINT32_WITHIN(600000, 40000000, table.x_bend_ppm_per_m);
}

static void level(double z_nm, double x[3])
{
    x[0] = 46e6 + 0.0 * z_nm;
    x[1] = 0.0;
    x[2] = 0.0;
}

static void test_cylinder_has_none(void)
{
    part.x = level;
    make();
    TEST_ASSERT_EQUAL_UINT32(0, table.x_slope_ppm);
    TEST_ASSERT_EQUAL_UINT32(0, table.x_bend_ppm_per_m);
}

/// A profile that falls by 1.5 um from one slice to the next and is level at both.
static void step(double z_nm, double x[3])
{
    level(z_nm, x);
    x[0] -= z_nm > 375000.0 ? 1500.0 : 0.0;
}

/// The quintic between them is steepest in the middle, with 15/8 of the mean slope. Its curvature
/// reaches 5.774 (in the fall per squared spacing), of which the sample at a quarter of the slice
/// finds 5.625.
static void test_peak_between_two_slices_is_seen(void)
{
    part.x = step;
    part.x_frac_bits = 4;
    make();
    TEST_ASSERT_UINT32_WITHIN(20, 11250, table.x_slope_ppm);
    TEST_ASSERT_UINT32_WITHIN(1000000, 135000000, table.x_bend_ppm_per_m);
}

static void test_units_do_not_depend_on_the_unit_of_the_table(void)
{
    part.x_frac_bits = 4;
    make();
    TEST_ASSERT_UINT32_WITHIN(20, 24000, table.x_slope_ppm);
}
