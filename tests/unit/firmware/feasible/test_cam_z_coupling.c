// SPDX-License-Identifier: Apache-2.0
// Motion of Z in a cut and its demands on other axes, in numbers that come out even, and in those
// that are just above: there a demand is rounded up. Between two lobes they are compared with the
// largest sum on a grid of a thousandth.
#include "cam_feasible_inner.h"
#include "cam_motion.h"
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

static void with_way(uint32_t slope_ppm, uint32_t bend_ppm_per_mm)
{
    table.way.knots = &knot;
    table.way_slope_ppm = slope_ppm;
    table.way_bend_ppm_per_mm = bend_ppm_per_mm;
}

static void expect(double want, double found)
{
    TEST_ASSERT_DOUBLE_WITHIN(1e-12 * want, want, found);
}

static double speed(uint64_t feed_nm, uint32_t mrpm)
{
    cut.feed_nm = feed_nm;
    cut.peak_mrpm = mrpm;
    return cam_z_coupling_z_um_per_s(&cut);
}

static void test_quantities_of_a_cut(void)
{
    expect(62.83185307179586, cam_cut_omega(600000));
    table.z_first_nm = -2000000000;
    table.z_last_nm = 2000000000;
    TEST_ASSERT_EQUAL_UINT64(4000000000, cam_cut_span_nm(&cut));
}

static void test_speed_of_z_is_feed_times_turns(void)
{
    expect(1000.0, speed(100000, 600000));
    expect(10000000.0, speed(10000000, 60000000));
    expect(7.0 * 42857143.0 / 6e7, speed(7, 42857143));
    expect(7.0 * 42857143.0 / 6e7, cam_z_coupling_along_um_per_s(&cut));
}

static void test_way_makes_z_faster_where_the_port_moves_it(void)
{
    with_way(1500000, 0);
    expect(1500000.0, speed(1000000, 60000000));
    params.z_is_measured = 1;
    expect(1000000.0, speed(1000000, 60000000));
    params.z_is_measured = 0;
    table.has_stations = true; // there X runs by the helix
    expect(1000000.0, cam_z_coupling_along_um_per_s(&cut));
    table.has_stations = false;
    expect(1500000.0, cam_z_coupling_along_um_per_s(&cut));
}

/// Ramps are made for the programmed feed and not longer than the part.
static void test_ramps_of_a_helix_need_an_acceleration(void)
{
    static const struct {
        uint32_t mrpm;
        int32_t ramp_turns, z_last_nm;
        uint64_t programmed_nm;
        double needed;
    } rows[] = {{600000, 10, 10000000, 100000, 1.0},
                {60000000, 1, 10000000, 100000, 100000.0},
                {60000000, 3, 10000000, 100001, 100001.0 / 3.0},
                {60000000, 10, 10000000, 100000, 10000.0},
                {60000000, 10, 1000000, 100000, 10000.0},
                {60000000, 10, 500000, 100000, 20000.0}};
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        cut.feed_nm = i == 0u ? 100000 : 5;
        cut.peak_mrpm = rows[i].mrpm;
        cut.programmed_nm = rows[i].programmed_nm;
        params.feed_ramp_turns = rows[i].ramp_turns;
        table.z_last_nm = rows[i].z_last_nm;
        expect(rows[i].needed, cam_z_coupling_z_mm_per_s2(&cut));
    }
}

/// The change of a feed that the way has is that of its bend, times the square of the speed.
static void test_way_adds_its_bend_to_the_acceleration(void)
{
    with_way(1000000, 1000000);
    cut.peak_mrpm = 60000000; // 100 mm/s
    cut.feed_nm = 100000;
    const double plain = 10000.0;
    const double bent = 10000.0;
    expect(plain + bent, cam_z_coupling_z_mm_per_s2(&cut));
    table.way_slope_ppm = 2000000;
    expect(2.0 * plain + bent, cam_z_coupling_z_mm_per_s2(&cut));
    expect(2.0 * plain + bent, cam_z_coupling_along_mm_per_s2(&cut));
    table.has_stations = true;
    expect(plain, cam_z_coupling_along_mm_per_s2(&cut));
    params.z_is_measured = 1;
    expect(plain + bent, cam_z_coupling_z_mm_per_s2(&cut));
    expect(0.0, cam_z_coupling_z_feeding_mm_per_s2(&cut));
}

static void test_ring_helix_has_the_speed_and_the_acceleration_of_its_ramps(void)
{
    table.is_ring_helix = true;
    const uint32_t most = (uint32_t)params.z_acceleration_mm_per_s2;
    const uint32_t ramp_q32 = cam_feed_ramp_q32(100000, 600000, most);
    expect((double)cam_feed_speed_um_per_s(100000, 600000, ramp_q32),
           cam_z_coupling_z_um_per_s(&cut));
    TEST_ASSERT_TRUE(cam_z_coupling_z_um_per_s(&cut) > 1000.0);
    expect((double)cam_feed_least_acceleration(100000, 600000), cam_z_coupling_z_mm_per_s2(&cut));
    expect(most, cam_z_coupling_z_feeding_mm_per_s2(&cut));
    params.z_is_measured = 1; // who moves it knows no rings
    expect(1000.0, cam_z_coupling_z_um_per_s(&cut));
    expect(1.0, cam_z_coupling_z_mm_per_s2(&cut));
    expect(0.0, cam_z_coupling_z_feeding_mm_per_s2(&cut));
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
    expect(0.0, d.speed + d.speed_per_rad + d.acceleration);
}

/// A thousand slices of 1 um pass in a second. Patterns of lobes do not drift.
static void test_drift_is_the_change_times_the_slices_that_pass(void)
{
    const cam_change_t change = {.most = 4000000000, .per_rad = 3000000000, .kink = 1000000};
    params.z_is_measured = 1;
    const cam_z_coupling_t d = drift(10000, change, 20000);
    expect(4e9, d.speed);
    expect(3e9, d.speed_per_rad);
    expect(2e10, d.acceleration);
    table.n_lobes = 1;
    expect_no_drift();
    table.n_lobes = 0;
    cut.feed_nm = 0;
    expect_no_drift();
}

/// While Z accelerates, here by 1 mm/s^2, the slices pass more and more quickly.
static void test_acceleration_of_z_adds_to_the_drift(void)
{
    const cam_change_t change = {.most = 2000000000};
    expect(2e9, drift(10000, change, 20000).acceleration);
    cut.peak_mrpm = 60000000;
    params.feed_ramp_turns = 1; // 100 m/s^2
    expect(2e9, drift(UINT32_C(1000000000), change, 1).acceleration);
}

/// Twice the rate over the angle times the angular speed.
static void test_rate_that_differs_over_the_angle_is_an_acceleration(void)
{
    const cam_z_coupling_t d = {.speed = 1000.0, .speed_per_rad = 50.0, .acceleration = 7.0};
    expect(6283.185307179586 + 7.0, cam_z_coupling_acceleration(&cut, &d));
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
        most[0] = fmax(most[0], e * p->f1 + e1 * p->f * x);
        most[1] = fmax(most[1], e * p->f2 + e1 * x * (2.0 * p->f1 + n * p->f * spindle) +
                                    n * e2 * p->f * x * x);
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
            (double)fixture_random_range(&random, 1000000, 15000000),
            (double)fixture_random_range(&random, 1000000, 60000000),
            (double)fixture_random_range(&random, 10000000, 900000000)};
        double most[2];
        const uint32_t n = 1u + (uint32_t)k % 8u;
        exact(&t, (double)feed_nm, &p, n, most);
        const double first = cam_z_coupling_lobes_first(&t, feed_nm, &p);
        const double second = cam_z_coupling_lobes_second(&t, feed_nm, &p, n);
        TEST_ASSERT_TRUE(first >= most[0] * (1.0 - 1e-6) && first <= most[0] * 1.09 + 10.0);
        TEST_ASSERT_TRUE(second >= most[1] * (1.0 - 1e-6) && second <= most[1] * 1.12 + 10.0);
        TEST_ASSERT_TRUE(first >= p.f1 && second >= p.f2);
    }
}

static void test_needs_rise_with_the_feed(void)
{
    cam_table_t t = {.least_change_nm = 100000, .ratio_max_q20 = 1u << 20};
    const cam_z_coupling_peaks_t p = {8e6, 12e6, 40e6};
    double before = 0.0;
    for (uint64_t feed_nm = 1; feed_nm < UINT64_C(1) << 24; feed_nm = feed_nm * 5u / 4u + 1u) {
        const double second = cam_z_coupling_lobes_second(&t, feed_nm, &p, 8u);
        TEST_ASSERT_TRUE(second >= before);
        before = second;
    }
    t.least_change_nm = 0; // no change at all
    expect(p.f1, cam_z_coupling_lobes_first(&t, 1u << 24, &p));
    expect(p.f2, cam_z_coupling_lobes_second(&t, 1u << 24, &p, 80u));
}
