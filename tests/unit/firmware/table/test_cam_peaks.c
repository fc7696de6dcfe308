// SPDX-License-Identifier: Apache-2.0
// How much a channel changes from slice to slice, against the surface that the table was made of.
#include "cam_peaks.h"
#include "fixture_image.h"
#include "unity.h"
#include <math.h>
#include <string.h>

#define PI 3.14159265358979323846

static fixture_image_t image;
static cam_table_t table;
static fixture_part_t part; // slices every 100 um

void setUp(void)
{
    part = fixture_part_short();
}

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
    const double per_rad_q26 = 67108864.0 / (2.0 * PI);
    expect_bound(5e-5 * per_rad_q26, table.swing_change.most);
    expect_bound(1e-4 * per_rad_q26, table.swing_change.per_rad);
    part.swing = NULL;
    (void)change();
    TEST_ASSERT_EQUAL_UINT32(0, table.swing_change.most);
}

/// u = A (1 - cos 2 theta) has u'' = 4 A cos 2 theta, 4 A / sqrt(2) rms; one slice is larger.
static void test_rms_is_that_of_the_largest_slice(void)
{
    part.u = turned_by_a_radian;
    (void)change();
    const double exact = 400000.0 / sqrt(2.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.001 * exact, exact, table.u2_rms_nm_per_rad2);
    part.u = one_slice;
    part.log2_repeat = 1;
    part.frac_bits = 3;
    (void)change();
    double u[3];
    fixture_cosine_oval(PI / 2.0, 100000.0, u);
    const double largest = fabs(u[2]) / sqrt(2.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.001 * largest + 2.0, largest, table.u2_rms_nm_per_rad2);
}

enum { n_flat_slices = 3, n_flat_knots = 4 };

static cam_knot_t flat[n_flat_slices * n_flat_knots];

/// @return a channel of bare knots, which are all 0 but for what a test writes
static cam_channel_t bare(uint32_t log2_repeat, uint32_t frac_bits)
{
    memset(flat, 0, sizeof flat);
    return (cam_channel_t){.knots = flat,
                           .n_slices = n_flat_slices,
                           .log2_knots = 2,
                           .log2_repeat = log2_repeat,
                           .frac_bits = frac_bits};
}

static void fill(uint32_t from, uint32_t to, cam_knot_t knot)
{
    for (uint32_t i = from; i < to; i++) {
        flat[i] = knot;
    }
}

/// Expect the least whole number above what is exact, but for a share of it and for a slack.
static void expect_next(double exact, double share, double slack, uint32_t found)
{
    TEST_ASSERT_TRUE((double)found >= exact);
    TEST_ASSERT_TRUE((double)found <= exact * (1.0 + share) + slack + 1.0);
}

/// A turn has 2^26 units; the bound is that of one LSB more.
static void test_standing_swing_is_bounded_by_the_next_thousandth_of_a_degree(void)
{
    for (int32_t p = -300; p <= 300; p++) {
        cam_channel_t ch = bare(0, p < 0 ? 3 : 0);
        ch.value_offset = p % 7;
        fill(0, 1, (cam_knot_t){.p = p * (1 + p * p)}); // all sizes up to 27 million
        const double lsb = fabs((double)flat[0].p + ldexp(ch.value_offset, (int)ch.frac_bits));
        const double rest = fabs(ldexp(ch.value_offset, (int)ch.frac_bits));
        const double exact = ldexp((fmax(lsb, rest) + 1.0) * 360e3, -26 - (int)ch.frac_bits);
        expect_next(exact, 0.0, 0.0, cam_peaks_of_swing(&ch).most_mdeg);
    }
}

/// Where all knots stand at 0 with the slope v, a Bernstein coefficient of the slope is -4 v.
static void test_slope_of_a_swing_is_bounded_by_the_next_whole_number(void)
{
    for (int32_t v = 1; v < 20000000; v += 1 + v / 7) {
        const cam_channel_t ch = bare(v % 3 == 0 ? 2 : 0, v % 2 == 0 ? 3 : 0);
        fill(0, n_flat_slices * n_flat_knots, (cam_knot_t){.v = v % 5 == 0 ? -v : v});
        const double n = ldexp(1.0, 2 + (int)ch.log2_repeat);
        const double exact = ldexp(4.0 * v * n * 180e3 / PI, -26 - (int)ch.frac_bits);
        expect_next(exact, 4e-6, 0.0, cam_peaks_of_swing(&ch).first_mdeg_per_rad);
    }
}

/// Where all knots have the second derivative 2 a alone, it is the largest one; its bound is wider
/// by 24 a / 8192. The slack is that of one LSB, and of the one behind the first conversion.
static void test_bend_of_a_swing_is_bounded_by_the_next_whole_number(void)
{
    for (int32_t a = 1; a < 1000000; a += 1 + a / 30) {
        const cam_channel_t ch = bare(4, a % 2 == 0 ? 1 : 0);
        fill(0, n_flat_slices * n_flat_knots, (cam_knot_t){.a = a % 5 == 0 ? -a : a});
        const double n = 64.0;
        const double mdeg = 90e3 / (PI * PI);
        const double unit = ldexp(1.0, -26 - (int)ch.frac_bits);
        const double exact = (2.0 + 24.0 / 8192.0) * a * n * n * mdeg * unit;
        expect_next(exact, 11e-6, (n * n * mdeg + n * 8192.0) * unit,
                    cam_peaks_of_swing(&ch).second_mdeg_per_rad2);
    }
}

static void test_bounds_of_a_swing_saturate(void)
{
    const cam_channel_t ch = bare(14, 0);
    fill(0, 1, (cam_knot_t){.a = CAM_TABLE_SUM_MAX});
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, cam_peaks_of_swing(&ch).second_mdeg_per_rad2);
}

static void test_each_knot_counts_for_the_swing(void)
{
    for (uint32_t i = 0; i < n_flat_slices * n_flat_knots; i++) {
        const cam_channel_t ch = bare(0, 0);
        fill(i, i + 1u, (cam_knot_t){.p = 1 << 20, .v = 1 << 20, .a = 1 << 20});
        const cam_swing_peaks_t found = cam_peaks_of_swing(&ch);
        TEST_ASSERT_GREATER_THAN_UINT32(5625, found.most_mdeg);
        TEST_ASSERT_GREATER_THAN_UINT32(3580, found.first_mdeg_per_rad);
        TEST_ASSERT_GREATER_THAN_UINT32(4559, found.second_mdeg_per_rad2);
    }
}

/// @return that many LSB in whole units, rounded up
static uint32_t whole(double lsb, uint32_t frac_bits)
{
    return (uint32_t)ceil(ldexp(ceil(lsb), -(int)frac_bits));
}

/// The second slice differs from both others in one member of all its knots, so that the difference
/// jumps by twice as much. Tenths of 4 v and of a are Bernstein coefficients of the value.
static void test_change_is_the_next_whole_unit(void)
{
    for (int32_t i = 1; i < 200; i++) {
        const uint32_t frac = (uint32_t)i % 4u;
        const cam_channel_t ch = bare(0, frac);
        fill(4, 8, (cam_knot_t){.p = i});
        cam_change_t found = cam_peaks_of_change(&ch);
        TEST_ASSERT_EQUAL_UINT32(whole(i, frac), found.most);
        TEST_ASSERT_EQUAL_UINT32(whole(2.0 * i, frac), found.kink);
        TEST_ASSERT_EQUAL_UINT32(0, found.per_rad);
        fill(4, 8, (cam_knot_t){.v = -i});
        found = cam_peaks_of_change(&ch);
        TEST_ASSERT_EQUAL_UINT32(whole(0.4 * i, frac), found.most);
        TEST_ASSERT_EQUAL_UINT32(whole(0.8 * i, frac), found.kink);
        fill(4, 8, (cam_knot_t){.a = i});
        found = cam_peaks_of_change(&ch);
        TEST_ASSERT_EQUAL_UINT32(whole(0.1 * i, frac), found.most);
        TEST_ASSERT_EQUAL_UINT32(whole(ceil(0.5 * i) * 2.0 / PI, frac), found.per_rad);
    }
}

/// From the slice below a pattern to it, and from there on, the slope changes by 4 v.
static void test_change_of_slope_is_hardly_above_the_next_whole_unit(void)
{
    for (int32_t v = 1; v < 20000000; v += 1 + v / 5) {
        const cam_channel_t ch = bare(v % 3 == 0 ? 2 : 0, 0);
        fill(4, 8, (cam_knot_t){.v = v});
        const double n = ldexp(1.0, 2 + (int)ch.log2_repeat);
        expect_next(4.0 * v * n / (2.0 * PI), 6e-6, 0.0, cam_peaks_of_change(&ch).per_rad);
    }
}

/// The last slice has none above it: what its knots are to the slice below counts once.
static void test_change_to_the_last_slice_counts(void)
{
    const cam_channel_t ch = bare(0, 0);
    fill(11, 12, (cam_knot_t){.p = 1000});
    TEST_ASSERT_EQUAL_UINT32(1000, cam_peaks_of_change(&ch).most);
    TEST_ASSERT_EQUAL_UINT32(1000, cam_peaks_of_change(&ch).kink);
    fill(11, 12, (cam_knot_t){0});
    fill(0, 1, (cam_knot_t){.p = 1000});
    TEST_ASSERT_EQUAL_UINT32(1000, cam_peaks_of_change(&ch).most);
    TEST_ASSERT_EQUAL_UINT32(1000, cam_peaks_of_change(&ch).kink);
}
