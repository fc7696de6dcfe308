// SPDX-License-Identifier: Apache-2.0
// Motion of Z in a cut and its demands on other axes, in numbers that come out even, and in those
// that are just above: there a demand is rounded up. Between two lobes they are compared with the
// largest sum on a grid of a thousandth.
#include "cam_z_coupling.h"
#include "cam_feed.h"
#include "fixture_random.h"
#include "unity.h"
#include <math.h> // fabs, fmax, ldexp

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

/// Speeds count in whole r/min; ramps are made for the programmed feed and not longer than the
/// part.
static void test_ramps_of_a_helix_need_an_acceleration(void)
{
    static const struct {
        uint32_t mrpm;
        int32_t ramp_turns, z_last_nm;
        uint64_t programmed_nm, needed;
    } rows[] = {{600000, 10, 10000000, 100000, 1},       {59999001, 1, 10000000, 100000, 100000},
                {59999001, 1, 10000000, 100001, 100001}, {59999001, 3, 10000000, 100001, 33334},
                {60000000, 10, 10000000, 100000, 10000}, {60000000, 10, 1000000, 100000, 10000},
                {60000000, 10, 500000, 100000, 20000}};
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        cut.feed_nm = i == 0u ? 100000 : 5;
        cut.peak_mrpm = rows[i].mrpm;
        cut.programmed_nm = rows[i].programmed_nm;
        params.feed_ramp_turns = rows[i].ramp_turns;
        table.z_last_nm = rows[i].z_last_nm;
        TEST_ASSERT_EQUAL_UINT64(rows[i].needed, cam_z_coupling_z_mm_per_s2(&cut));
    }
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

static void expect_no_drift(void)
{
    const cam_change_t change = {.most = 1000, .per_rad = 1000, .kink = 1000};
    const cam_z_coupling_t d = drift(10000, change, 20000);
    TEST_ASSERT_EQUAL_UINT64(0, d.speed + d.speed_per_rad + d.acceleration);
}

/// A thousand slices of 1 um pass in a second, and at most as many as at the speed of any slide;
/// the largest numbers show every digit of a unit. Patterns of lobes do not drift.
static void test_drift_is_the_change_times_the_slices_that_pass(void)
{
    const cam_change_t change = {.most = 4000000000, .per_rad = 3000000000, .kink = 1000000};
    params.z_is_measured = 1;
    const cam_z_coupling_t d = drift(10000, change, 20000);
    TEST_ASSERT_EQUAL_UINT64(4000000000, d.speed);
    TEST_ASSERT_EQUAL_UINT64(3000000000, d.speed_per_rad);
    TEST_ASSERT_EQUAL_UINT64(UINT64_C(20000000000), d.acceleration);
    table.n_lobes = 1;
    expect_no_drift();
    table.n_lobes = 0;
    cut.feed_nm = 0;
    expect_no_drift();
    cut.feed_nm = 10000000;
    for (uint32_t mrpm = 39320400; mrpm <= 60000000u; mrpm += 20679600) {
        cut.peak_mrpm = mrpm;
        const cam_change_t small = {.most = 1000000};
        TEST_ASSERT_EQUAL_UINT64(6553400000, drift(10000, small, 1).speed);
    }
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

/// Twice the rate over the angle times the angular speed, 6284 hundredths of a rad/s.
static void test_rate_that_differs_over_the_angle_is_an_acceleration(void)
{
    const cam_z_coupling_t d = {.speed = 1000, .speed_per_rad = 50, .acceleration = 7};
    TEST_ASSERT_EQUAL_UINT64(6284 + 7, cam_z_coupling_acceleration(&cut, &d));
    const cam_z_coupling_t slow = {.speed_per_rad = 1};
    TEST_ASSERT_EQUAL_UINT64(126, cam_z_coupling_acceleration(&cut, &slow)); // of 125.7
}

/// Largest needs, by the equations.
static void exact(const cam_table_t *t, double a_feed_nm, const cam_z_coupling_peaks_t *p, double n,
                  double most[2])
{
    const double half = t->speed.knots != NULL ? 0.5 : 1.0;
    const double x =
        ldexp(t->ratio_max_q20, -20) * a_feed_nm / (6.283185307179586 * t->least_change_nm * half);
    const double spindle = t->spindle_peak_ppm_per_rad * 1e-6;
    most[0] = most[1] = 0.0;
    for (int i = 0; i <= 1000; i++) {
        const double s = i / 1000.0;
        const double e = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
        const double e1 = 30.0 * s * s * (1.0 - s) * (1.0 - s);
        const double e2 = fabs(60.0 * s * (1.0 - s) * (1.0 - 2.0 * s));
        most[0] = fmax(most[0], e * (double)p->f1 + e1 * (double)p->f * x);
        most[1] = fmax(most[1], e * (double)p->f2 +
                                    e1 * x * (2.0 * (double)p->f1 + n * (double)p->f * spindle) +
                                    n * e2 * (double)p->f * x * x);
    }
}

/// A bound is never below, and above only by what the grid of twentieths costs.
static void test_needs_are_bounded_tightly(void)
{
    fixture_random_t random = {87u};
    for (int k = 0; k < 2000 / fixture_rarer; k++) {
        const cam_table_t t = {
            .least_change_nm = (uint32_t)fixture_random_range(&random, 80000, 40000000),
            .ratio_max_q20 = (uint32_t)fixture_random_range(&random, 1 << 20, 4 << 20),
            .spindle_peak_ppm_per_rad = (uint32_t)fixture_random_range(&random, 0, 10000000),
            .speed.knots = k % 2 == 0 ? NULL : &knot,
        };
        const uint64_t feed_nm = (uint64_t)fixture_random_range(&random, 1000, 3000000);
        const cam_z_coupling_peaks_t p = {
            (uint64_t)fixture_random_range(&random, 1000000, 15000000),
            (uint64_t)fixture_random_range(&random, 1000000, 60000000),
            (uint64_t)fixture_random_range(&random, 10000000, 900000000)};
        double most[2];
        const uint32_t n = 1u + (uint32_t)k % 8u;
        exact(&t, (double)feed_nm, &p, n, most);
        const double first = (double)cam_z_coupling_lobes_first(&t, feed_nm, &p);
        const double second = (double)cam_z_coupling_lobes_second(&t, feed_nm, &p, n);
        TEST_ASSERT_TRUE(first >= most[0] * (1.0 - 1e-6) && first <= most[0] * 1.09 + 10.0);
        TEST_ASSERT_TRUE(second >= most[1] * (1.0 - 1e-6) && second <= most[1] * 1.12 + 10.0);
        TEST_ASSERT_TRUE(first >= (double)p.f1 && second >= (double)p.f2);
    }
}

/// A change over next to nothing needs no more than the steepest one: numbers stay in their words.
static void test_needs_rise_with_the_feed_up_to_the_steepest_change(void)
{
    cam_table_t t = {.least_change_nm = 100000, .ratio_max_q20 = 1u << 20};
    const cam_z_coupling_peaks_t p = {8000000u, 12000000u, 40000000u};
    uint64_t before = 0;
    for (uint64_t feed_nm = 1; feed_nm < UINT64_C(1) << 24; feed_nm = feed_nm * 5u / 4u + 1u) {
        const uint64_t second = cam_z_coupling_lobes_second(&t, feed_nm, &p, 8u);
        TEST_ASSERT_TRUE(second >= before);
        before = second;
    }
    uint64_t first[3], second[3];
    t.ratio_max_q20 = 4u << 20;
    for (uint32_t i = 0; i < 3u; i++) { // no change at all, two that are too steep
        t.least_change_nm = i == 2u ? 3u : i;
        first[i] = cam_z_coupling_lobes_first(&t, 1u << 24, &p);
        second[i] = cam_z_coupling_lobes_second(&t, 1u << 24, &p, 80u);
    }
    TEST_ASSERT_TRUE(first[0] == p.f1 && second[0] == p.f2);
    TEST_ASSERT_TRUE(first[1] == first[2] && second[1] == second[2]);
    TEST_ASSERT_TRUE(first[1] <= p.f1 + 2u * p.f * 34u); // 2^25 ppm, 15 / 8
    TEST_ASSERT_TRUE(first[1] > p.f * 60u);
}
