// SPDX-License-Identifier: Apache-2.0
// What the speed channel demands of a speed loop, against doubles of the ratio it was made of; and
// a loop of first order that is told it, simulated.
#include "cam_feasible.h"
#include "cam_peaks.h"
#include "fixture_play.h"
#include "unity.h"
#include <math.h>

static fixture_play_t f;
static fixture_part_t part;
static const double pi = 3.14159265358979323846;

void setUp(void)
{
    part = fixture_part_modulated();
    fixture_play_init(&f, &part);
}

/// @return the largest r + c r r' over both ends of the part
static double largest(double c)
{
    double most = 0.0;
    for (int i = 0; i < 2000; i++) {
        double r[3];
        fixture_ratio(2.0 * pi * (i / 2) / 1000.0, i % 2 == 0 ? 0.0 : part.z_last_nm, r);
        most = fmax(most, r[0] + c * r[0] * r[1]);
    }
    return most;
}

static void test_largest_fall_is_that_of_the_ratio(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * 0.75e6, 0.75e6, f.table.spindle_demand.fall_ppm_per_rad);
}

/// Above the largest by what a chord is above the curve; below it by what lies between the knots of
/// this table, 11 degrees apart.
static void test_set_point_is_bounded_at_any_lag(void)
{
    for (int i = 0; i <= 240; i++) {
        const double c = i * 0.05;
        const double exact = largest(c);
        const double bound = ldexp(
            (double)cam_peaks_set_point_q20(&f.table.spindle_demand, (uint64_t)(c * 65536.0)), -20);
        TEST_ASSERT_TRUE(bound >= exact * 0.99);
        TEST_ASSERT_TRUE(c > 8.0 || bound <= exact * 1.002);
    }
}

static void test_table_without_modulation_demands_nothing(void)
{
    part = fixture_part_short();
    fixture_play_init(&f, &part);
    TEST_ASSERT_EQUAL_UINT32(0, f.table.spindle_demand.fall_ppm_per_rad);
    f.params.spindle_lag_us = 1000000;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_feasible(&f.table, &f.params, 200000, 20000).err);
}

static void test_slow_loop_is_refused_with_the_highest_speed_that_it_follows(void)
{
    f.params.spindle_lag_us = 100000; // 10 rad/s of bandwidth
    f.params.spindle_acceleration_mrad_per_s2 = 2000000000;
    f.params.spindle_limit_mrpm = 60000000;
    const cam_feasibility_t why = cam_feasible(&f.table, &f.params, 200000, 20000);
    const double omega = 200.0 * pi / 30.0;
    TEST_ASSERT_EQUAL_INT(cam_err_spindle_loop, why.err);
    TEST_ASSERT_EQUAL_INT64(10000, why.limit);
    TEST_ASSERT_DOUBLE_WITHIN(20.0, 750.0 * omega, (double)why.needed);
    TEST_ASSERT_DOUBLE_WITHIN(200.0, 10.0 / 0.75 * 30e3 / pi, why.highest_mrpm);
}

static void test_set_point_beyond_the_highest_speed_is_refused(void)
{
    f.params.spindle_lag_us = 25000;
    f.params.spindle_acceleration_mrad_per_s2 = 2000000000;
    f.params.spindle_limit_mrpm = 310000; // r is up to 1.425: 285 r/min
    const cam_feasibility_t why = cam_feasible(&f.table, &f.params, 200000, 20000);
    TEST_ASSERT_EQUAL_INT(cam_err_spindle_set_point, why.err);
    const double needed = 200e3 * largest(200.0 * pi / 30.0 * 0.025);
    TEST_ASSERT_DOUBLE_WITHIN(0.003 * needed, needed, (double)why.needed);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_feasible(&f.table, &f.params, why.highest_mrpm, 20000).err);
}
