// SPDX-License-Identifier: Apache-2.0
// The feed against height: Z over the turns, and ways that are refused. test_cam_z_coupling.c has
// what they demand of Z.
#define OWN_SET_UP
#include "cam_table_inner.h"
#include "fixture_newer.h"
#include "fixture_shaft.h"
#include "play_bench.h"
#include <math.h>

#define PI 3.14159265358979323846

static double share; ///< of the feed by which it swings about its mean

/// On 1 mm of height the feed is mean * (1 + share sin(2 pi z)) over the helix's height.
static void sine(double z_nm, double w[3])
{
    const double k = 2.0 * PI / 1e6;
    const double at = k * (z_nm - part.z_first_nm);
    w[0] = share * (1.0 - cos(at)) / k;
    w[1] = share * sin(at);
    w[2] = share * k * cos(at);
}

void setUp(void)
{
    part = fixture_part_short();
    share = 0.5;
    fixture_play_init(&f, &part);
}

static cam_err_t with_way(uint32_t n_knots)
{
    fixture_image_make(&f.image, &part);
    fixture_newer_way(&f.image, sine, n_knots, 4);
    return cam_table_check(f.image.bytes, f.image.size, &f.table);
}

/// The part is 1 mm high, so 16 is the most knots that the spacing of the format allows.
enum { n_knots = 15 };

static void test_way_is_measured(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, with_way(n_knots));
    TEST_ASSERT_UINT32_WITHIN(3000, 1500000, f.table.way_slope_ppm);
    TEST_ASSERT_DOUBLE_WITHIN(0.02, 1.0, f.table.way_bend_ppm_per_mm / (0.5 * 2.0 * PI * 1e6));
    fixture_image_make(&f.image, &part);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_table_check(f.image.bytes, f.image.size, &f.table));
    TEST_ASSERT_EQUAL_UINT32(1000000, f.table.way_slope_ppm);
    TEST_ASSERT_EQUAL_UINT32(0, f.table.way_bend_ppm_per_mm);
}

/// Check a way of bare knots.
static cam_err_t check_bare(const cam_knot_t knots[n_knots])
{
    cam_table_t table = {
        .way = {.knots = knots, .n_slices = n_knots, .span_nm = 1000000, .frac_bits = 4}};
    return cam_feed_profile_check(&table);
}

/// A way that falls back in one slice and regains it evenly, whichever slice it is.
static void test_a_way_that_falls_in_one_slice_is_refused(void)
{
    enum { rise = 1000000 * 16 / (n_knots - 1), drop = rise / 3 };
    for (int fallen = -1; fallen < n_knots - 1; fallen++) {
        cam_knot_t knots[n_knots] = {{0}};
        for (int i = 1; i < n_knots - 1; i++) {
            knots[i].p = fallen < 0 ? 0 : drop * i / (n_knots - 1) - (i > fallen ? drop : 0);
        }
        TEST_ASSERT_EQUAL_INT(fallen < 0 ? cam_ok : cam_err_image_channel, check_bare(knots));
    }
}

/// Between two knots each of the five Bernstein coefficients of the slope bounds it: the slopes at
/// both knots and the curvatures there, which count from the slope of their knot. Of a feed that
/// falls to a fiftieth of its mean one LSB more is refused.
static void test_a_way_is_bounded_by_slopes_and_curvatures_of_its_knots(void)
{
    enum { plain = 1000000 * 16 / (n_knots - 1), deepest = plain - plain * 2 / 100 };
    enum { last = n_knots - 1 };
    for (int more = 0; more < 2; more++) {
        const int32_t d = deepest + more;
        const struct {
            const char *name;
            int at[2];
            cam_knot_t knot[2];
        } rows[] = {
            {"slope of the first knot", {0, 1}, {{.v = -d}}},
            {"slope of a knot", {7, 8}, {{.v = -d}}},
            {"curvature of the first knot", {0, 1}, {{.a = -2 * d}}},
            {"curvatures of a slice", {7, 8}, {{.a = -2 * d}, {.a = 2 * d}}},
            {"slope at the begin alone", {0, 1}, {{.v = -d, .a = 2 * d}}},
            {"slope at the end alone", {last, 1}, {{.v = -d, .a = -2 * d}}},
            {"curvature and slope", {3, 2}, {{.v = -deepest / 2, .a = 2 * (deepest / 2 - d)}}},
        };
        for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
            cam_knot_t knots[n_knots] = {{0}};
            knots[rows[i].at[0]] = rows[i].knot[0];
            knots[rows[i].at[1]] = rows[i].knot[1];
            TEST_ASSERT_EQUAL_INT_MESSAGE(more == 0 ? cam_ok : cam_err_image_channel,
                                          check_bare(knots), rows[i].name);
        }
    }
}

/// Check a way with stations that brings Z to 14 heights [um] one after the other, at rest at each.
static cam_err_t check_rests(const double z_um[n_knots], cam_table_t *table)
{
    static cam_knot_t knots[n_knots];
    for (int i = 0; i < n_knots; i++) {
        knots[i].p = (int32_t)(z_um[i] * 16000.0 - 16e6 * i / (n_knots - 1));
        knots[i].v = -16000000 / (n_knots - 1);
    }
    *table = (cam_table_t){
        .way = {.knots = knots,
                .n_slices = n_knots,
                .span_nm = 1000000,
                .slices_per_nm_q48 = (uint32_t)(((n_knots - UINT64_C(1)) << 48) / 1000000u),
                .frac_bits = 4},
        .has_stations = true};
    return cam_feed_profile_check(table);
}

/// With stations Z stands and goes back, up to a micrometre beyond its first and last height. From
/// one rest to the next it is fastest in the middle: 15/8 of its mean.
static void test_with_stations_z_stays_between_its_first_and_its_last_height(void)
{
    static const struct {
        double z_um[n_knots];
        cam_err_t err;
        double fastest_um; ///< in a slice
    } rows[] = {
        {{0, 0, 0, 0, 0, 0, 0, 500, 500, 500, 500, 500, 500, 500, 500}, cam_ok, 500.0},
        {{0, 99, 199, 299, 399, 499, 599, 699, 799, 499, 199, 399, 599, 799, 1000}, cam_ok, 300.0},
        {{0, 200.9, 0, 0, -0.9, 0, 0, 0, 0, 0, 0, 0, 200, 200, 200}, cam_ok, 200.9},
        {{0, 201.1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 200, 200, 200}, cam_err_image_channel, 0.0},
        {{0, 200, 0, 0, -1.1, 0, 0, 0, 0, 0, 0, 0, 200, 200, 200}, cam_err_image_channel, 0.0}};
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        cam_table_t table;
        TEST_ASSERT_EQUAL_INT(rows[i].err, check_rests(rows[i].z_um, &table));
        if (rows[i].err == cam_ok) {
            const double most = 1.875 * rows[i].fastest_um * (n_knots - 1) * 1e3;
            TEST_ASSERT_DOUBLE_WITHIN(2e-3 * most, most, table.way_slope_ppm);
        }
    }
}

/// With stations Z may end anywhere above its begin within the reach of an axis; the offset counts.
static void test_end_of_a_way_with_stations_is_where_an_axis_reaches(void)
{
    static const struct {
        int32_t offset_nm, ahead_nm, first_nm;
        bool is_good;
    } cases[] = {{0, -900000, 0, true},        {-500000, 0, 0, true},
                 {-500000, -600000, 0, false}, {300000, -1300000, 0, true},
                 {300000, -1300001, 0, false}, {0, 0, 999000000, true},
                 {0, 1000, 999000000, false},  {-1000, 1000, 999000000, true}};
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        cam_knot_t knots[2] = {{.p = -cases[i].offset_nm * 16}, {.p = cases[i].ahead_nm * 16}};
        const int32_t rise = knots[1].p - knots[0].p; // a straight line between the two
        knots[0].v = knots[1].v = rise;
        cam_table_t table = {.way = {.knots = knots,
                                     .n_slices = 2,
                                     .span_nm = 1000000,
                                     .z_first_nm = cases[i].first_nm,
                                     .value_offset = cases[i].offset_nm,
                                     .frac_bits = 4},
                             .has_stations = true};
        TEST_ASSERT_EQUAL_INT(cases[i].is_good ? cam_ok : cam_err_image_channel,
                              cam_feed_profile_check(&table));
    }
}

static void test_z_follows_the_way_over_the_turns(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, with_way(n_knots));
    fixture_play_configure(&f);
    engage();
    const double fed = 1e6 / part.feed_nm;
    for (double turns = 0.0; turns < fed + 2.5; turns += 0.0417) {
        const double helix_nm = part.z_first_nm + eased(turns, 2.0, fed) * part.feed_nm;
        double w[3];
        sine(helix_nm, w);
        TEST_ASSERT_DOUBLE_WITHIN(30.0, helix_nm + w[0], z_at(turns));
    }
}

/// The same with stations: Z goes back, and U's section is found on the helix.
static void test_with_stations_z_goes_back_and_the_section_does_not(void)
{
    share = 1.3;
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel, with_way(n_knots));
    fixture_image_put(&f.image, fixture_image_in(fixture_newer_last(&f.image), fixture_in_path),
                      1u);
    fixture_image_seal(&f.image);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_table_check(f.image.bytes, f.image.size, &f.table));
    fixture_play_configure(&f);
    engage();
    const double fed = 1e6 / part.feed_nm;
    double last_nm = 0.0;
    double most_back_nm = 0.0;
    for (double turns = 0.0; turns < fed + 2.5; turns += 0.0417) {
        const double helix_nm = part.z_first_nm + eased(turns, 2.0, fed) * part.feed_nm;
        double w[3];
        sine(helix_nm, w);
        const double z_nm = z_at(turns);
        TEST_ASSERT_DOUBLE_WITHIN(80.0, helix_nm + w[0], z_nm);
        const double slices = ldexp((double)f.motion.height_q32, -32) / (part.n_slices - 1u);
        TEST_ASSERT_DOUBLE_WITHIN(30.0, helix_nm, part.z_first_nm + slices * 1e6);
        most_back_nm = fmax(most_back_nm, last_nm - z_nm);
        last_nm = z_nm;
    }
    TEST_ASSERT_DOUBLE_WITHIN(300.0, 0.3 * 0.0417 * part.feed_nm, most_back_nm);
}

/// @return the verdict on the present image
static cam_err_t check(void)
{
    fixture_image_seal(&f.image);
    return cam_table_check(f.image.bytes, f.image.size, &f.table);
}

/// 2^24 nm and 2^8 LSB fill a word exactly, so the end of the last way is 0 only to 32 bits.
static void test_way_begins_and_ends_with_the_table(void)
{
    for (int i = 0; i < 4; i++) {
        TEST_ASSERT_EQUAL_INT(cam_ok, with_way(n_knots));
        const uint32_t channel = fixture_newer_last(&f.image);
        if (i < 2) {
            fixture_image_knots(&f.image, channel)[i * (n_knots - 1)].p++;
            fixture_image_remeasure(&f.image, channel);
        } else if (i == 2) {
            const uint32_t last = fixture_image_get(&f.image, fixture_at_z_last);
            fixture_image_put(&f.image, fixture_at_z_last, last - 1u);
        } else {
            fixture_image_put(&f.image, fixture_image_in(channel, fixture_in_frac_bits), 8u);
            fixture_image_put(&f.image, fixture_image_in(channel, fixture_in_value_offset),
                              1u << 24);
        }
        TEST_ASSERT_EQUAL_INT(cam_err_image_channel, check());
    }
}

static void test_rings_and_shafts_have_no_way_and_a_skirt_has_one(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, with_way(n_knots));
    fixture_newer_way(&f.image, sine, n_knots, 4);
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel, check());
    part.is_ring_helix = true;
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel, with_way(n_knots));
    const fixture_shaft_t shaft = fixture_shaft_three();
    fixture_shaft_make(&f.image, &shaft);
    TEST_ASSERT_EQUAL_INT(cam_ok, check());
    fixture_newer_way(&f.image, sine, n_knots, 4);
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel, check());
}
