// SPDX-License-Identifier: Apache-2.0
// Stations: a way along which Z stands at the lobes of a shaft, and what is refused of it.
#include "cam_build.h"
#include "cam_feasible.h"
#include "cam_feed_profile.h"
#include "fixture_newer.h"
#include "fixture_play.h"
#include "fixture_shaft.h"
#include "unity.h"

enum { n_knots = 15, tick_hz = 20000 };

static fixture_image_t image;
static cam_table_t table;
static double slope; ///< of Z over the station

static void straight(double z_nm, double w[3])
{
    w[0] = (slope - 1.0) * z_nm;
    w[1] = slope - 1.0;
    w[2] = 0.0;
}

static cam_err_t check(uint32_t path)
{
    const fixture_shaft_t shaft = fixture_shaft_three();
    fixture_shaft_make(&image, &shaft);
    fixture_newer_way(&image, straight, n_knots, 4);
    const uint32_t way = fixture_newer_last(&image);
    fixture_image_put(&image, fixture_image_in(way, fixture_in_path), path);
    fixture_image_seal(&image);
    return cam_table_check(image.bytes, image.size, &table);
}

void setUp(void)
{
    slope = 0.0;
}

static void test_z_may_stand_at_the_lobes(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, check(1));
    TEST_ASSERT_TRUE(table.has_stations && !table.is_ring_helix);
    for (int32_t s_nm = 0; s_nm <= 1000000; s_nm += 9973) {
        TEST_ASSERT_INT32_WITHIN(1, 0, cam_feed_profile_at(&table, s_nm).z_nm);
    }
    TEST_ASSERT_EQUAL_INT32(0, cam_feed_profile_z_last_nm(&table));
}

static void test_way_of_a_shaft_has_stations_and_does_not_turn_back(void)
{
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel, check(0));
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel, check(2));
    slope = -0.01;
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel, check(1));
    slope = 1.5;
    TEST_ASSERT_EQUAL_INT(cam_ok, check(1));
    TEST_ASSERT_INT32_WITHIN(1, 1500000, cam_feed_profile_z_last_nm(&table));
}

static void test_skirt_has_no_stations(void)
{
    fixture_part_t part = fixture_part_short();
    fixture_image_make(&image, &part);
    fixture_newer_way(&image, straight, n_knots, 4);
    const uint32_t way = fixture_newer_last(&image);
    fixture_image_put(&image, fixture_image_in(way, fixture_in_path), 1u);
    fixture_image_seal(&image);
    TEST_ASSERT_EQUAL_INT(cam_err_image_channel, cam_table_check(image.bytes, image.size, &table));
}

static void test_range_of_z_ends_where_z_does(void)
{
    static cam_config_t config;
    cam_params_t params = cam_param_defaults();
    slope = 0.5;
    TEST_ASSERT_EQUAL_INT(cam_ok, check(1));
    TEST_ASSERT_EQUAL_INT(cam_ok,
                          cam_build_config(&config, &params, &table, 3000000, tick_hz, tick_hz));
    TEST_ASSERT_INT32_WITHIN(1, 500000 + params.z_margin_nm, config.play.z_high_nm);
    TEST_ASSERT_EQUAL_INT32(-params.z_margin_nm, config.play.z_low_nm);
}

static void test_measured_z_is_refused_before_motion(void)
{
    cam_params_t params = cam_param_defaults();
    params.swing_speed_mdeg_per_s = 1000000;
    params.feed_nm = 1000;
    TEST_ASSERT_EQUAL_INT(cam_ok, check(1));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_feasible_check(&table, &params, 1000, tick_hz));
    params.z_is_measured = 1;
    TEST_ASSERT_EQUAL_INT(cam_err_z_stations, cam_feasible_check(&table, &params, 1000, tick_hz));
}

/// A machine cuts all lobes while Z stands: the lobe is found by the helix, Z by the way.
static void test_z_stands_while_one_lobe_after_the_other_is_cut(void)
{
    static fixture_play_t f;
    fixture_part_t part = fixture_part_short();
    fixture_play_init(&f, &part);
    TEST_ASSERT_EQUAL_INT(cam_ok, check(1));
    f.image = image;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_table_check(f.image.bytes, f.image.size, &f.table));
    fixture_play_configure(&f);
    TEST_ASSERT_TRUE(fixture_play_bring(&f, cam_state_cutting));
    uint32_t seen = 0;
    for (uint32_t i = 0; i < 100000u && f.want.state == cam_state_cutting; i++) {
        fixture_play_tick(&f);
        seen |= 1u << f.plan.shaft.i_lobe;
        TEST_ASSERT_EQUAL_INT64(0, f.axis[hal_axis_z].pos_q10);
    }
    TEST_ASSERT_EQUAL_INT(cam_state_disengaging, f.want.state);
    TEST_ASSERT_EQUAL_HEX32(7, seen);
}

/// Without stations a measured Z finds the lobe, and is smoothed for it.
static void test_a_measured_z_finds_the_lobe(void)
{
    static fixture_play_t f;
    fixture_part_t part = fixture_part_short();
    fixture_play_init(&f, &part);
    const fixture_shaft_t shaft = fixture_shaft_three();
    fixture_shaft_make(&f.image, &shaft);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_table_check(f.image.bytes, f.image.size, &f.table));
    fixture_play_measure_z(&f, 0);
    TEST_ASSERT_TRUE(fixture_play_bring(&f, cam_state_cutting));
    TEST_ASSERT_EQUAL_UINT32(0, f.plan.shaft.i_lobe);
    while (f.in.actual_nm[hal_axis_z] < 800000) {
        f.in.actual_nm[hal_axis_z] += 100;
        fixture_play_tick(&f);
    }
    TEST_ASSERT_EQUAL_UINT32(2, f.plan.shaft.i_lobe);
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, f.want.state);
    TEST_ASSERT_INT64_WITHIN(20000 * 256, 800000 * 256, f.plan.shaft.z_q8); // by the lead of a plan
}
