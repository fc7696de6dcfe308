// SPDX-License-Identifier: Apache-2.0
// How Z moves in a cut and what that adds to the other axes, in numbers that come out even, and in
// those that are just above: there a demand is rounded up.
#include "cam_z_coupling.h"
#include "cam_feed.h"
#include "unity.h"

static cam_table_t table;
static cam_params_t params;
static cam_cut_t cut;
static const cam_knot_t knot;

/// 0.1 mm per turn at 600 r/min are 1 mm/s.
void setUp(void)
{
    params = cam_param_defaults();
    params.feed_ramp_turns = 10;
    table = (cam_table_t){.z_last_nm = 10000000};
    cut = (cam_cut_t){.t = &table,
                      .p = &params,
                      .mean_mrpm = 600000,
                      .peak_mrpm = 600000,
                      .feed_nm = 100000,
                      .programmed_nm = 100000};
}

static void with_way(uint32_t slope_ppm, uint32_t bend_ppm_per_m)
{
    table.way.knots = &knot;
    table.way_slope_ppm = slope_ppm;
    table.way_bend_ppm_per_m = bend_ppm_per_m;
}

static uint64_t speed(uint64_t feed_nm, uint32_t mrpm)
{
    cut.feed_nm = feed_nm;
    cut.peak_mrpm = mrpm;
    return cam_z_coupling_z_um_per_s(&cut);
}

static void test_quotients_are_rounded_up(void)
{
    static const uint64_t fifths[] = {0, 1, 1, 1, 1, 1, 2};
    for (uint64_t a = 0; a < 7u; a++) {
        TEST_ASSERT_EQUAL_UINT64(fifths[a], cam_cut_divided_up(a, 5));
    }
    TEST_ASSERT_EQUAL_INT64(-2, cam_cut_smaller(-2, 1));
    TEST_ASSERT_EQUAL_INT64(-2, cam_cut_smaller(1, -2));
    TEST_ASSERT_EQUAL_UINT64(7, cam_cut_greater(7, 3));
    TEST_ASSERT_EQUAL_UINT64(7, cam_cut_greater(3, 7));
    TEST_ASSERT_EQUAL_UINT64(62832, cam_cut_omega_mrad_per_s(600000)); // 62831.853
    TEST_ASSERT_EQUAL_UINT64(104719756, cam_cut_omega_mrad_per_s(1000000000));
    table.z_first_nm = -2000000000;
    table.z_last_nm = 2000000000;
    TEST_ASSERT_EQUAL_UINT64(4000000000, cam_cut_span_nm(&cut));
}

static void test_speed_of_z_is_feed_times_turns(void)
{
    TEST_ASSERT_EQUAL_UINT64(1000, speed(100000, 600000));
    TEST_ASSERT_EQUAL_UINT64(10000000, speed(10000000, 60000000));
    TEST_ASSERT_EQUAL_UINT64(6, speed(7, 42857143)); // a 60 000 000th above 5
    TEST_ASSERT_EQUAL_UINT64(6, cam_z_coupling_x_um_per_s(&cut));
}

static void test_way_makes_z_faster_where_the_port_moves_it(void)
{
    with_way(1500000, 0);
    TEST_ASSERT_EQUAL_UINT64(1500000, speed(1000000, 60000000));
    table.way_slope_ppm = 1500001;
    TEST_ASSERT_EQUAL_UINT64(1500000, speed(999999, 60000000)); // of 1 499 999.5
    params.z_is_measured = 1;
    TEST_ASSERT_EQUAL_UINT64(999999, speed(999999, 60000000));
    params.z_is_measured = 0;
    table.has_stations = true; // there X runs by the helix
    TEST_ASSERT_EQUAL_UINT64(999999, cam_z_coupling_x_um_per_s(&cut));
    table.has_stations = false;
    TEST_ASSERT_EQUAL_UINT64(1500000, cam_z_coupling_x_um_per_s(&cut));
}

static void test_ramps_of_a_helix_need_an_acceleration(void)
{
    TEST_ASSERT_EQUAL_UINT64(1, cam_z_coupling_z_mm_per_s2(&cut));
    cut.peak_mrpm = 59999001; // counts as whole r/min
    params.feed_ramp_turns = 1;
    TEST_ASSERT_EQUAL_UINT64(100000, cam_z_coupling_z_mm_per_s2(&cut));
    cut.feed_nm = 5; // the ramps are made for the programmed feed
    TEST_ASSERT_EQUAL_UINT64(100000, cam_z_coupling_z_mm_per_s2(&cut));
    cut.programmed_nm = 100001;
    TEST_ASSERT_EQUAL_UINT64(100001, cam_z_coupling_z_mm_per_s2(&cut));
    params.feed_ramp_turns = 3;
    TEST_ASSERT_EQUAL_UINT64(33334, cam_z_coupling_z_mm_per_s2(&cut));
}

/// A part of five turns has no room for ramps of ten.
static void test_ramps_are_not_longer_than_the_part(void)
{
    cut.peak_mrpm = 60000000;
    TEST_ASSERT_EQUAL_UINT64(10000, cam_z_coupling_z_mm_per_s2(&cut));
    table.z_last_nm = 1000000;
    TEST_ASSERT_EQUAL_UINT64(10000, cam_z_coupling_z_mm_per_s2(&cut));
    table.z_last_nm = 500000;
    TEST_ASSERT_EQUAL_UINT64(20000, cam_z_coupling_z_mm_per_s2(&cut));
}

/// The change of a feed that the way has is that of its bend, times the square of the speed in
/// whole tenths of a millimetre, and one more of each.
static void test_way_adds_its_bend_to_the_acceleration(void)
{
    with_way(1000000, 1000000000);
    cut.peak_mrpm = 60000000; // 100 mm/s
    cut.feed_nm = 100000;
    const uint64_t plain = 10000;
    TEST_ASSERT_EQUAL_UINT64(plain + 10020 + 1, cam_z_coupling_z_mm_per_s2(&cut));
    table.way_slope_ppm = 2000000;
    TEST_ASSERT_EQUAL_UINT64(2u * plain + 10020 + 1, cam_z_coupling_z_mm_per_s2(&cut));
    TEST_ASSERT_EQUAL_UINT64(2u * plain + 10020 + 1, cam_z_coupling_x_mm_per_s2(&cut));
    table.has_stations = true;
    TEST_ASSERT_EQUAL_UINT64(plain, cam_z_coupling_x_mm_per_s2(&cut));
    params.z_is_measured = 1;
    TEST_ASSERT_EQUAL_UINT64(plain + 10020 + 1, cam_z_coupling_z_mm_per_s2(&cut));
    TEST_ASSERT_EQUAL_UINT64(0, cam_z_coupling_z_feeding_mm_per_s2(&cut));
    params.z_is_measured = 0;
    table.way_slope_ppm = 1000000;
    cut.feed_nm = 10000000; // as fast as a slide is taken to be: 65 535 tenths and one
    TEST_ASSERT_EQUAL_UINT64(plain + 42948362 + 1, cam_z_coupling_z_mm_per_s2(&cut));
}

static void test_ring_helix_has_the_speed_and_the_acceleration_of_its_ramps(void)
{
    table.is_ring_helix = true;
    const uint32_t most = (uint32_t)params.z_acceleration_mm_per_s2;
    const uint32_t ramp_q32 = cam_feed_ramp_q32(100000, 600000, most);
    TEST_ASSERT_EQUAL_UINT64(cam_feed_speed_um_per_s(100000, 600000, ramp_q32),
                             cam_z_coupling_z_um_per_s(&cut));
    TEST_ASSERT_TRUE(cam_z_coupling_z_um_per_s(&cut) > 1000u);
    TEST_ASSERT_EQUAL_UINT64(cam_feed_least_acceleration(100000, 600000),
                             cam_z_coupling_z_mm_per_s2(&cut));
    TEST_ASSERT_EQUAL_UINT64(most, cam_z_coupling_z_feeding_mm_per_s2(&cut));
    params.z_is_measured = 1; // who moves it knows no rings
    TEST_ASSERT_EQUAL_UINT64(1000, cam_z_coupling_z_um_per_s(&cut));
    TEST_ASSERT_EQUAL_UINT64(1, cam_z_coupling_z_mm_per_s2(&cut));
    TEST_ASSERT_EQUAL_UINT64(0, cam_z_coupling_z_feeding_mm_per_s2(&cut));
}

static cam_z_coupling_t drift(uint32_t span_nm, cam_change_t change, uint32_t set_point_hz)
{
    const cam_channel_t ch = {.n_slices = 11, .span_nm = span_nm};
    return cam_z_coupling_of(&cut, &ch, &change, set_point_hz);
}

/// A thousand slices of 1 um pass in a second; the largest numbers show every digit of a unit.
static void test_drift_is_the_change_times_the_slices_that_pass(void)
{
    const cam_change_t change = {.most = 4000000000, .per_rad = 3000000000, .kink = 1000000};
    params.z_is_measured = 1;
    cam_z_coupling_t d = drift(10000, change, 20000);
    TEST_ASSERT_EQUAL_UINT64(4000000000, d.speed);
    TEST_ASSERT_EQUAL_UINT64(3000000000, d.speed_per_rad);
    TEST_ASSERT_EQUAL_UINT64(UINT64_C(20000000000), d.acceleration);
    cut.feed_nm = 0; // nothing passes
    d = drift(10000, change, 20000);
    TEST_ASSERT_EQUAL_UINT64(0, d.speed + d.speed_per_rad + d.acceleration);
}

/// While Z accelerates, here by 1 mm/s^2, the slices pass more and more quickly.
static void test_acceleration_of_z_adds_to_the_drift(void)
{
    const cam_change_t change = {.most = 2000000000};
    TEST_ASSERT_EQUAL_UINT64(2000000000, drift(10000, change, 20000).acceleration);
    cut.peak_mrpm = 59999001;
    params.feed_ramp_turns = 1; // 100 m/s^2 count in full, and 6.6 km/s^2 as 1 km/s^2
    TEST_ASSERT_EQUAL_UINT64(2000000, drift(UINT32_C(1000000000), change, 1).acceleration / 1000u);
    cut.programmed_nm = 6600000;
    TEST_ASSERT_EQUAL_UINT64(20000000, drift(UINT32_C(1000000000), change, 1).acceleration / 1000u);
}

static void test_speed_of_z_is_judged_up_to_that_of_any_slide(void)
{
    const cam_change_t change = {.most = 1000000};
    cut.feed_nm = 10000000;
    cut.peak_mrpm = 39320400;
    params.z_is_measured = 1;
    TEST_ASSERT_EQUAL_UINT64(6553400000, drift(10000, change, 1).speed);
    cut.peak_mrpm = 60000000;
    TEST_ASSERT_EQUAL_UINT64(6553400000, drift(10000, change, 1).speed);
}

static void test_patterns_of_lobes_do_not_drift(void)
{
    const cam_change_t change = {.most = 1000, .per_rad = 1000, .kink = 1000};
    table.n_lobes = 1;
    const cam_z_coupling_t d = drift(10000, change, 20000);
    TEST_ASSERT_EQUAL_UINT64(0, d.speed + d.speed_per_rad + d.acceleration);
}

/// Twice the rate over the angle times the angular speed, 6284 hundredths of a rad/s.
static void test_rate_that_differs_over_the_angle_is_an_acceleration(void)
{
    const cam_z_coupling_t d = {.speed = 1000, .speed_per_rad = 50, .acceleration = 7};
    TEST_ASSERT_EQUAL_UINT64(6284 + 7, cam_z_coupling_acceleration(&cut, &d));
    const cam_z_coupling_t slow = {.speed_per_rad = 1};
    TEST_ASSERT_EQUAL_UINT64(126, cam_z_coupling_acceleration(&cut, &slow)); // of 125.7
}
