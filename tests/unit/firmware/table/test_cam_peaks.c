// SPDX-License-Identifier: Apache-2.0
// The demands of a table, against the functions that it was made of: how much a channel changes
// from slice to slice, the swing, the speed channel and its promises, slope and bend of X.
#include "cam_table_inner.h" // cam_peaks_set_point_q20, cam_peaks_check, cam_peaks_of_change
#include "image_bench.h"
#include <math.h>
#include <string.h>

#define PI 3.14159265358979323846

/// An upper bound is at most 2 % too large; the rounding of knots adds 2 nm. Below 0 the bound is
/// 0.
static void expect_bound(double exact, uint32_t found, const char *name)
{
    TEST_ASSERT_TRUE_MESSAGE((double)found >= exact - 0.5, name);
    TEST_ASSERT_TRUE_MESSAGE((double)found <= (exact < 0.0 ? 0.0 : 1.02 * exact + 2.0), name);
}

static void same_everywhere(double theta, double z_nm, double u[3])
{
    (void)z_nm;
    fixture_cosine_oval(theta, 0.0, u);
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

/// A single slice differs from all others: the change goes there and back.
static void one_slice(double theta, double z_nm, double u[3])
{
    const bool is_there = z_nm > 450000.0 && z_nm < 550000.0;
    fixture_cosine_oval(theta, is_there ? 100000.0 : 0.0, u);
}

/// Slices every 100 um. The ovality of the short skirt rises by 10 um per slice; (1 - cos) / 4 is
/// at most 1/2, and so is its slope. The step from lobe to lobe is all kink; that of a single slice
/// goes there and back.
static void test_change_is_that_of_the_surface(void)
{
    const double radian = 200000.0 * sin(1.0);
    const struct {
        const char *name;
        fixture_surface_fn *u;
        bool is_repeated;
        double most, per_rad, kink;
    } rows[] = {
        {"even rise", fixture_cosine_oval, false, 5000.0, 5000.0, 0.0},
        {"equal slices", same_everywhere, false, -1.0, -1.0, -1.0},
        {"lobes turned by a radian", turned_by_a_radian, false, radian, 2.0 * radian, radian},
        {"repeated patterns", turned_by_a_radian, true, radian, 2.0 * radian, radian},
        {"one slice", one_slice, false, 5000.0, 5000.0, 10000.0}};
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        part.u = rows[i].u;
        part.log2_repeat = rows[i].is_repeated ? 1u : 0u;
        part.frac_bits = rows[i].is_repeated ? 3u : 7u;
        make();
        expect_bound(rows[i].most, table.u_change.most, rows[i].name);
        expect_bound(rows[i].per_rad, table.u_change.per_rad, rows[i].name);
        expect_bound(rows[i].kink, table.u_change.kink, rows[i].name);
    }
}

/// Where the tool swings, the change of the swing is measured as well: 1e-10 rad/nm over 500 um.
static void test_swing_changes_in_its_own_unit(void)
{
    part = fixture_part_swung();
    make();
    const double per_rad_q26 = 67108864.0 / (2.0 * PI);
    expect_bound(5e-5 * per_rad_q26, table.swing_change.most, "swing");
    expect_bound(1e-4 * per_rad_q26, table.swing_change.per_rad, "swing");
    part.swing = NULL;
    make();
    TEST_ASSERT_EQUAL_UINT32(0, table.swing_change.most);
}

/// u = A (1 - cos 2 theta) has u'' = 4 A cos 2 theta, 4 A / sqrt(2) rms; one slice is larger.
static void test_rms_is_that_of_the_largest_slice(void)
{
    part.u = turned_by_a_radian;
    make();
    const double exact = 400000.0 / sqrt(2.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.001 * exact, exact, table.u2_rms_nm_per_rad2);
    part.u = one_slice;
    part.log2_repeat = 1;
    part.frac_bits = 3;
    make();
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
    const cam_channel_t fine = bare(14, 0);
    fill(0, 1, (cam_knot_t){.a = CAM_TABLE_SUM_MAX});
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, cam_peaks_of_swing(&fine).second_mdeg_per_rad2);
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

/// The last slice has none above it: what its knots are to the slice below counts once, as for the
/// first.
static void test_change_to_the_last_slice_counts(void)
{
    for (uint32_t i = 0; i < 12u; i += 11u) {
        const cam_channel_t ch = bare(0, 0);
        fill(i, i + 1u, (cam_knot_t){.p = 1000, .v = 5000});
        TEST_ASSERT_EQUAL_UINT32(3000, cam_peaks_of_change(&ch).most);
        TEST_ASSERT_EQUAL_UINT32(3000, cam_peaks_of_change(&ch).kink);
    }
}

/// Image of the modulated part with a promise lowered by a share of itself.
static cam_err_t lowered(size_t at, double share)
{
    fixture_image_make(&image, &part);
    return with_word(at, (uint32_t)floor(fixture_image_get(&image, at) * (1.0 - share)));
}

static void test_speed_channel_is_described_and_its_promises_hold(void)
{
    static const size_t at[] = {fixture_at_u1_peak, fixture_at_u2_peak, fixture_at_spindle_peak};
    make();
    TEST_ASSERT_NULL(table.speed.knots);
    TEST_ASSERT_EQUAL_UINT32(CAM_TABLE_RATIO_ONE, table.ratio_max_q20);
    TEST_ASSERT_EQUAL_UINT32(0, table.spindle_peak_ppm_per_rad);
    TEST_ASSERT_EQUAL_UINT32(0, table.spindle_demand.fall_ppm_per_rad);
    TEST_ASSERT_EACH_EQUAL_UINT32(CAM_TABLE_RATIO_ONE, table.spindle_demand.set_q20,
                                  cam_spindle_demand_places);
    TEST_ASSERT_EQUAL_INT(cam_err_image_limits, with_word(fixture_at_spindle_peak, 1u));
    part = fixture_part_modulated();
    make();
    TEST_ASSERT_NOT_NULL(table.speed.knots);
    TEST_ASSERT_EQUAL_UINT32(3, table.speed.n_slices);
    TEST_ASSERT_DOUBLE_WITHIN(3e-6, 1.425, table.ratio_max_q20 / (double)CAM_TABLE_RATIO_ONE);
    TEST_ASSERT_DOUBLE_WITHIN(2.0, fixture_image_get(&image, fixture_at_spindle_peak),
                              table.spindle_peak_ppm_per_rad);
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_EQUAL_INT(cam_ok, lowered(at[i], 0.0));
        TEST_ASSERT_EQUAL_INT(cam_err_image_limits, lowered(at[i], 0.03)); // knots alone are seen
        TEST_ASSERT_EQUAL_INT(cam_err_image_limits, with_word(at[i], 0u));
    }
}

static void test_absurd_curvature_is_refused_without_overflow(void)
{
    part = fixture_part_modulated();
    TEST_ASSERT_NOT_EQUAL_INT(cam_ok,
                              with_word(fixture_image_in(fixture_u, fixture_in_frac_bits), 0u));
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

/// Above the largest by what a chord is above the curve; below it by what is between the knots of
/// this table, 11 degrees apart.
static void test_set_point_of_the_spindle_is_bounded_at_any_lag(void)
{
    part = fixture_part_modulated();
    make();
    const cam_spindle_demand_t *demand = &table.spindle_demand;
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * 0.75e6, 0.75e6, demand->fall_ppm_per_rad);
    for (int i = 0; i <= 240; i += 5) {
        const double c = i * 0.05;
        double exact = 0.0; // the largest over both ends of the part
        for (int k = 0; k < 2000; k++) {
            double r[3];
            fixture_ratio(2.0 * PI * (k / 2) / 1000.0, k % 2 == 0 ? 0.0 : part.z_last_nm, r);
            exact = fmax(exact, r[0] + c * r[0] * r[1]);
        }
        const uint64_t bound_q20 = cam_peaks_set_point_q20(demand, (uint64_t)(c * 65536.0));
        const double bound = ldexp((double)bound_q20, -20);
        TEST_ASSERT_TRUE(bound >= exact * 0.99);
        TEST_ASSERT_TRUE(c > 8.0 || bound <= exact * 1.002);
    }
}

/// A profile that falls by 1.5 um from one slice to the next and is level at both.
static void step(double z_nm, double x[3])
{
    fixture_cylinder(z_nm, x);
    x[0] -= z_nm > 375000.0 ? 1500.0 : 0.0;
}

/// The parabola is steepest at its upper end, 600 000 nm from the largest radius. The quintic of a
/// step is steepest in the middle, with 15/8 of the mean slope; its curvature reaches 5.774 (in the
/// fall per squared spacing), of which the sample at a quarter of the slice finds 5.625.
static void test_slope_and_bend_of_x_are_those_of_the_profile(void)
{
    const struct {
        fixture_profile_fn *x;
        uint32_t frac_bits, slope_ppm, bend_ppm_per_mm;
    } rows[] = {{part.x, 8, 24000, 40000},
                {part.x, 4, 24000, 40000},
                {fixture_cylinder, 8, 0, 0},
                {step, 4, 11250, 135000}};
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        part.x = rows[i].x;
        part.x_frac_bits = rows[i].frac_bits;
        make();
        TEST_ASSERT_UINT32_WITHIN(rows[i].slope_ppm / 500u, rows[i].slope_ppm, table.x_slope_ppm);
        TEST_ASSERT_UINT32_WITHIN(rows[i].bend_ppm_per_mm / 66u, rows[i].bend_ppm_per_mm,
                                  table.x_bend_ppm_per_mm);
    }
}
