// SPDX-License-Identifier: Apache-2.0
// How much a channel changes from slice to slice, against the surface that the table was made of.
#include "cam_peaks.h"
#include "fixture_image.h"
#include "unity.h"
#include <math.h>

static fixture_image_t image;
static cam_table_t table;
static fixture_part_t part; // slices every 100 um

void setUp(void)
{
    part = fixture_part_short();
}

void tearDown(void) {}

static cam_change_t change(void)
{
    fixture_image_make(&image, &part);
    fixture_image_seal(&image);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_table_check(image.bytes, image.size, &table));
    return table.u_change;
}

/// Expect an upper bound that is at most 2 % too large; the rounding of knots adds 2 nm.
static void expect_bound(double exact, uint32_t found)
{
    TEST_ASSERT_TRUE((double)found >= exact - 0.5);
    TEST_ASSERT_TRUE((double)found <= 1.02 * exact + 2.0);
}

/// The ovality rises by 10 um per slice; (1 - cos) / 4 is at most 1/2, and so is its slope.
static void test_even_rise_has_no_kink(void)
{
    const cam_change_t found = change();
    expect_bound(5000.0, found.most);
    expect_bound(5000.0, found.per_rad);
    expect_bound(0.0, found.kink);
}

static void same_everywhere(double theta, double z_nm, double u[3])
{
    (void)z_nm;
    fixture_cosine_oval(theta, 0.0, u);
}

static void test_equal_slices_change_by_nothing(void)
{
    part.u = same_everywhere;
    const cam_change_t found = change();
    TEST_ASSERT_EQUAL_UINT32(0, found.most);
    TEST_ASSERT_EQUAL_UINT32(0, found.per_rad);
    TEST_ASSERT_EQUAL_UINT32(0, found.kink);
}

/// Two lobes, turned against each other by 1 radian: A cos(2 theta) - A cos(2 theta - 2) reaches
/// 2 A sin(1) between two knots.
static void turned_by_a_radian(double theta, double z_nm, double u[3])
{
    const double at = 2.0 * theta - (z_nm > 450000.0 ? 2.0 : 0.0);
    u[0] = 100000.0 * (1.0 - cos(at));
    u[1] = 200000.0 * sin(at);
    u[2] = 400000.0 * cos(at);
}

static void test_step_from_lobe_to_lobe_is_all_kink(void)
{
    part.u = turned_by_a_radian;
    const cam_change_t found = change();
    expect_bound(200000.0 * sin(1.0), found.most);
    expect_bound(400000.0 * sin(1.0), found.per_rad);
    expect_bound(200000.0 * sin(1.0), found.kink);
}

static void test_repeated_patterns_and_units_count(void)
{
    part.u = turned_by_a_radian;
    part.log2_repeat = 1;
    part.frac_bits = 3;
    const cam_change_t found = change();
    expect_bound(200000.0 * sin(1.0), found.most);
    expect_bound(400000.0 * sin(1.0), found.per_rad);
}

/// A single slice differs from all others: the change goes there and back.
static void one_slice(double theta, double z_nm, double u[3])
{
    const bool is_there = z_nm > 450000.0 && z_nm < 550000.0;
    fixture_cosine_oval(theta, is_there ? 100000.0 : 0.0, u);
}

static void test_kink_of_a_peak_is_twice_its_step(void)
{
    part.u = one_slice;
    const cam_change_t found = change();
    expect_bound(5000.0, found.most);
    expect_bound(10000.0, found.kink);
}

/// Where the tool swings, the change of the swing is measured as well: 1e-10 rad/nm over 500 um.
static void test_swing_changes_in_its_own_unit(void)
{
    part = fixture_part_swung();
    (void)change();
    const double per_rad_q26 = 67108864.0 / (2.0 * 3.14159265358979323846);
    expect_bound(5e-5 * per_rad_q26, table.swing_change.most);
    expect_bound(1e-4 * per_rad_q26, table.swing_change.per_rad);
    part.swing = NULL;
    (void)change();
    TEST_ASSERT_EQUAL_UINT32(0, table.swing_change.most);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_even_rise_has_no_kink);
    RUN_TEST(test_equal_slices_change_by_nothing);
    RUN_TEST(test_step_from_lobe_to_lobe_is_all_kink);
    RUN_TEST(test_repeated_patterns_and_units_count);
    RUN_TEST(test_kink_of_a_peak_is_twice_its_step);
    RUN_TEST(test_swing_changes_in_its_own_unit);
    return UNITY_END();
}
