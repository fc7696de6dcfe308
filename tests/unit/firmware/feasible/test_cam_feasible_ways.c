// SPDX-License-Identifier: Apache-2.0
// What X needs for its clearance and for the barrel, and U where its amplitude rises, against
// doubles.
#include "feasible_bench.h"
#include <math.h>

/// X crosses its clearance by the smooth step: 15/8 c n / t and 5.774 c (n / t)^2.
static void test_x_leaves_its_clearance_within_its_limits(void)
{
    params.x_clearance_nm = 100000000;
    params.x_speed_um_per_s = 100000;
    params.x_acceleration_mm_per_s2 = 1000000;
    const double n = 2500.0 / 60.0;
    expect_refused(cam_err_x_speed, 2500000, 1.875 * 1e5 * n / 10.0, 100000,
                   100000.0 / (1.875 * 1e5 / 10.0) * 60000.0);
    params.x_speed_um_per_s = 10000000;
    params.x_acceleration_mm_per_s2 = 2000;
    const double highest = sqrt(2000.0 / (5.7735 * 100.0)) * 10.0 * 60000.0;
    expect_refused(cam_err_x_acceleration, 2500000, 5.7735 * 100.0 * n * n / 100.0, 2000, highest);
    params.disengage_turns = 5; // the shorter of the two ramps decides
    expect_refused(cam_err_x_acceleration, 2500000, 5.7735 * 100.0 * n * n / 25.0, 2000,
                   highest / 2.0);
}

/// A slope of 0.2 and a radius of 10 mm, at a feed of 1 mm whose ramps take 10 turns.
static void test_x_follows_the_barrel_within_its_limits(void)
{
    table.x_slope_ppm = 200000;
    table.x_bend_ppm_per_m = 100000000;
    table.feed_nm = 1000000;
    params.feed_ramp_turns = 10;
    params.x_clearance_nm = 100000;
    params.x_speed_um_per_s = 8000;
    const double n = 2500.0 / 60.0;
    expect_refused(cam_err_x_speed, 2500000, 200.0 * n, 8000, 8000.0 / 200.0 * 60000.0);
    params.x_speed_um_per_s = 10000000;
    params.x_acceleration_mm_per_s2 = 200;
    const double per_n2 = 100.0 * 1e-6 * 1000.0 + 0.2 * 0.1; // [mm] of n^2
    expect_refused(cam_err_x_acceleration, 2500000, per_n2 * n * n, 200,
                   sqrt(200.0 / per_n2) * 60000.0);
    params.z_is_measured = 1; // others accelerate Z, so only the bend remains
    const double bent = 0.1 * n * n;
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * bent, bent, (double)judge(3000000).needed / 1.44);
}

/// Ticks of a plan, in which the slope of the smooth step stays the same, at 20 kHz.
enum { plan_ticks = 8 };

/// @return the largest e u'' + 2 e' u' + |e''| u over the smooth step e, where u, u' and u'' of the
///         oval are each at their largest and one tick takes e'' of a whole plan
/// @param f, f1, f2  largest magnitudes of u, u' and u''
/// @param spindle    largest |r r'|, with which the spindle accelerates: what that changes of the
///                   slope of the envelope one tick takes as well
static double engaging_peak_of(double turns, double f, double f1, double f2, double spindle)
{
    double most = 0.0;
    for (int i = 0; i <= 1000; i++) {
        const double s = i / 1000.0;
        const double per = 1.0 / (2.0 * pi * turns);
        const double e = s * s * s * (10.0 + s * (-15.0 + 6.0 * s));
        const double e1 = 30.0 * s * s * (1.0 - s) * (1.0 - s) * per;
        const double e2 = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) * per * per;
        most = fmax(most, e * f2 + 2.0 * e1 * f1 + plan_ticks * (fabs(e2) + e1 * spindle) * f);
    }
    return most;
}

static double engaging_peak(double turns)
{
    return engaging_peak_of(turns, 150000.0, 150000.0, 300000.0,
                            table.spindle_peak_ppm_per_rad * 1e-6);
}

/// An eccentric disc: u is as large as u' and u''. It needs more than u'' alone at any length.
static void test_engaging_of_a_disc_is_never_taken_too_small(void)
{
    const double w = 300.0 * 2.0 * pi / 60.0;
    table.u_max_nm = 0;
    table.u_min_nm = -14800000;
    table.u1_peak_nm_per_rad = 7400000;
    table.u2_peak_nm_per_rad2 = 8200000;
    table.limit_u_stroke_nm = 30000000;
    params.u_stroke_nm = 30000000;
    params.u_acceleration_mm_per_s2 = 1000;
    for (int turns = 1; turns <= 100; turns++) {
        params.engage_turns = turns;
        params.disengage_turns = 100;
        const cam_feasibility_t why = judge(300000);
        TEST_ASSERT_EQUAL_INT(cam_err_u_acceleration, why.err);
        const double bound = (double)why.needed * 1e6 / w / w;
        const double needed = engaging_peak_of(turns, 14.8e6, 7.4e6, 8.2e6, 0.0);
        TEST_ASSERT_TRUE(bound >= 0.9998 * needed && bound <= 1.031 * needed);
        TEST_ASSERT_TRUE(turns > 3 || needed > 1.04 * 8.2e6);
    }
}

/// A U that stands far off its middle moves there while it engages, however little its sections
/// ask for: e u' + e' u, which is e u'' + 2 e' u' with u' for u'' and half of u for u'.
static void test_engaging_of_an_offset_needs_speed(void)
{
    const double w = 300.0 * 2.0 * pi / 60.0;
    table.u_max_nm = 0;
    table.u_min_nm = -400000;
    table.u1_peak_nm_per_rad = 10000;
    table.u2_peak_nm_per_rad2 = 20000;
    params.u_speed_um_per_s = 100;
    params.disengage_turns = 100;
    for (int turns = 1; turns <= 20; turns++) {
        const double needed = engaging_peak_of(turns, 0.0, 400000.0 / 2.0, 10000.0, 0.0);
        params.engage_turns = turns;
        const cam_feasibility_t why = judge(300000);
        TEST_ASSERT_EQUAL_INT(cam_err_u_speed, why.err);
        const double bound = (double)why.needed * 1e3 / w;
        TEST_ASSERT_TRUE(bound >= 0.9998 * needed && bound <= 1.031 * needed + 100.0);
    }
}

static void expect_engaging_needs(void)
{
    const double w = 2500.0 * 2.0 * pi / 60.0;
    for (int turns = 1; turns <= 10; turns++) {
        params.engage_turns = turns;
        params.u_acceleration_mm_per_s2 = 10000;
        const double needed = engaging_peak(turns);
        const cam_feasibility_t why = judge(2500000);
        TEST_ASSERT_EQUAL_INT(cam_err_u_acceleration, why.err);
        const double bound = (double)why.needed * 1e6 / w / w;
        TEST_ASSERT_TRUE(bound >= 0.9998 * needed && bound <= 1.031 * needed);
    }
}

static void test_short_engaging_adds_to_what_u_needs(void)
{
    expect_engaging_needs();
}

static void test_short_engaging_with_a_modulated_spindle_adds_more(void)
{
    table.spindle_peak_ppm_per_rad = 1500000;
    expect_engaging_needs();
}
