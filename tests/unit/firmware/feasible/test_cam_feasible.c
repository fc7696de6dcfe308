// SPDX-License-Identifier: Apache-2.0
// Every limit with its numbers, against doubles; the reported highest speed is feasible itself.
// test_cam_feasible_ways.c has what X and the begin and end of a cut need.
#include "feasible_bench.h"
#include <math.h>

static void test_feasible_part_within_all_limits_passes(void)
{
    const cam_feasibility_t good = judge(2500000);
    TEST_ASSERT_EQUAL_INT(cam_ok, good.err);
    TEST_ASSERT_GREATER_THAN_UINT32(2500000, good.highest_mrpm);
}

static void test_spindle_limit_is_the_smaller_of_machine_and_table(void)
{
    params.spindle_limit_mrpm = 3000000;
    expect_refused(cam_err_spindle_speed, 3500000, 3500000, 3000000, 3000000);
    table.limit_spindle_mrpm = 2000000;
    expect_refused(cam_err_spindle_speed, 3500000, 3500000, 2000000, 2000000);
}

static void test_u_speed_limit_is_the_smaller_of_machine_and_table(void)
{
    params.u_speed_um_per_s = 30000;
    const double most = 30e6 / 150000 * 60000 / (2 * pi);
    expect_refused(cam_err_u_speed, 2500000, 150e3 * omega(2500e3) / 1e3, 30000, most);
    table.limit_u_speed_um_per_s = 15000;
    expect_refused(cam_err_u_speed, 2500000, 150e3 * omega(2500e3) / 1e3, 15000, most / 2);
}

static void test_u_acceleration_limit_is_the_smaller_of_machine_and_table(void)
{
    params.u_acceleration_mm_per_s2 = 15000;
    params.engage_turns = 100; // a short one adds to it
    params.disengage_turns = 100;
    const double needed = 300e3 * omega(2500e3) * omega(2500e3) / 1e6;
    const double most = sqrt(15e9 / 300e3) * 60000 / (2 * pi);
    expect_refused(cam_err_u_acceleration, 2500000, needed, 15000, most);
    table.limit_u_acceleration_mm_per_s2 = 3750;
    expect_refused(cam_err_u_acceleration, 2500000, needed, 3750, most / 2);
}

static void test_amplitude_scales_what_u_needs(void)
{
    params.u_speed_um_per_s = 30000;
    params.amplitude_ppm = 500000;
    TEST_ASSERT_EQUAL_INT(cam_ok, judge(2500000).err);
    params.amplitude_ppm = 1250000;
    expect_refused(cam_err_u_speed, 2500000, 1.25 * 150e3 * omega(2500e3) / 1e3, 30000,
                   30e6 / 187500 * 60000 / (2 * pi));
}

static void test_stroke_counts_the_travel_to_both_sides(void)
{
    table.u_max_nm = 700000;
    expect_refused(cam_err_u_stroke, 1000000, 700000, 600000, 0);
    table.u_max_nm = 150000;
    table.u_min_nm = -650000;
    expect_refused(cam_err_u_stroke, 1000000, 650000, 600000, 0);
    table.u_min_nm = 0;
    table.limit_u_stroke_nm = 200000;
    expect_refused(cam_err_u_stroke, 1000000, 150000, 100000, 0);
}

/// A retract that was set must fit behind the outermost place of the cut, and is blamed itself.
static void test_retract_that_was_set_counts_from_the_outermost_place(void)
{
    params.u_retract_nm = -700000;
    expect_refused(cam_err_u_retract, 1000000, 700000, 600000, 0);
    table.u_min_nm = -250000;
    params.u_retract_nm = -350001;
    expect_refused(cam_err_u_retract, 1000000, 600001, 600000, 0);
    params.u_retract_nm = -350000;
    TEST_ASSERT_EQUAL_INT(cam_ok, judge(1000000).err);
}

/// A part of 0.5 mm about its mean fits a stroke of 0.8 mm at the default retract of 0.5 mm.
static void test_default_retract_blocks_no_part_that_fits_the_stroke(void)
{
    params.u_stroke_nm = 800000;
    table.u_min_nm = -250000;
    table.u_max_nm = 250000;
    TEST_ASSERT_EQUAL_INT(cam_ok, judge(1000000).err);
    table.u_min_nm = -400000;
    table.u_max_nm = 400000;
    TEST_ASSERT_EQUAL_INT(cam_ok, judge(1000000).err);
    table.u_min_nm = -400001;
    expect_refused(cam_err_u_stroke, 1000000, 400001, 400000, 0);
}

static void test_feed_larger_than_the_part_is_refused(void)
{
    table.z_last_nm = 90000;
    expect_refused(cam_err_feed, 100000, 100000, 90000, 0);
    params.z_is_measured = 1;
    TEST_ASSERT_EQUAL_INT(cam_ok, judge(100000).err);
}

/// The course of the feed counts 2^22 turns, the ramps among them, whoever moves Z and whatever the
/// override; a turn of a ring-helix has a ring with it. No speed helps, and a larger feed does.
static void test_more_turns_than_are_counted_are_refused(void)
{
    table.z_last_nm = 4194304 - 100;
    params.feed_nm = 1;
    TEST_ASSERT_EQUAL_INT(cam_ok, judge(2500000).err);
    params.feed_ramp_turns = 99;
    table.z_last_nm += 2;
    const cam_feasibility_t why = judge(2500000);
    TEST_ASSERT_EQUAL_INT(cam_err_turns, why.err);
    TEST_ASSERT_EQUAL_INT64(4194305, why.needed);
    TEST_ASSERT_EQUAL_INT64(4194304, why.limit);
    TEST_ASSERT_GREATER_THAN_UINT32(2500000, why.highest_mrpm);
    TEST_ASSERT_GREATER_THAN_UINT32(1, why.largest_feed_nm);
    TEST_ASSERT_EQUAL_INT(cam_err_turns, cam_feasible_check(&table, &params, 2500000, 20000));
    params.feed_override_ppm = 1500000;
    TEST_ASSERT_EQUAL_INT(cam_err_turns, judge(2500000).err);
    params.feed_override_ppm = 1000000;
    params.z_is_measured = 1;
    TEST_ASSERT_EQUAL_INT(cam_err_turns, judge(2500000).err);
    params.feed_nm = 2;
    TEST_ASSERT_EQUAL_INT(cam_ok, judge(2500000).err);
    params.z_is_measured = 0;
    table.is_ring_helix = true;
    TEST_ASSERT_EQUAL_INT(cam_err_turns, judge(2500000).err);
    params.feed_nm = 3;
    TEST_ASSERT_EQUAL_INT(cam_ok, judge(2500000).err);
}

/// What exceeds the limit of an axis is told first.
static void test_an_axis_is_blamed_before_the_turns(void)
{
    params.feed_nm = 1;
    params.spindle_limit_mrpm = 3000000;
    TEST_ASSERT_EQUAL_INT(cam_err_spindle_speed, judge(3500000).err);
    TEST_ASSERT_EQUAL_INT(cam_err_turns, judge(2500000).err);
}

/// A ring-helix of 0.2 mm: 4 feed n^2 of acceleration, feed n / (1 - r) of speed at least. What is
/// reported as the highest speed has 1 / n = feed / v + v / a.
static void test_ring_helix_needs_ramps_of_z(void)
{
    table.is_ring_helix = true;
    params.feed_nm = 200000;
    params.z_acceleration_mm_per_s2 = 1000;
    const double per_s = 2500.0 / 60.0;
    expect_refused(cam_err_z_acceleration, 2500000, 0.8 * per_s * per_s, 1000,
                   sqrt(1000.0 / 0.8) * 60e3);
    params.z_acceleration_mm_per_s2 = 2000;
    params.z_speed_um_per_s = 6000;
    const double r = 0.5 - sqrt(0.25 - 0.2 * per_s * per_s / 2000);
    expect_refused(cam_err_z_speed, 2500000, 200 * per_s / (1.0 - r), 6000,
                   60e3 / (0.2 / 6.0 + 6.0 / 2000));
    params.z_is_measured = 1;
    TEST_ASSERT_EQUAL_INT(cam_ok, judge(2500000).err);
}

/// 1 / n = feed / v + v / a, where v is the lesser of Z's speed and of sqrt(feed a), at which the
/// two ramps meet, and v / a is at least 1 / 255 of the rest.
static double ring_mrpm(double feed_mm, double v_mm_per_s, double a_mm_per_s2)
{
    const double v = fmin(v_mm_per_s, sqrt(feed_mm * a_mm_per_s2));
    const double feed_s = feed_mm / v;
    return 60e3 / (feed_s + fmax(v / a_mm_per_s2, feed_s / 255.0));
}

static void test_highest_speed_of_a_ring_helix_is_the_edge_of_both_limits(void)
{
    table.is_ring_helix = true;
    table.u.log2_knots = 2;
    table.u.log2_repeat = 0;
    table.z_last_nm = 1000000000;
    table.u1_peak_nm_per_rad = 0;
    table.u2_peak_nm_per_rad2 = 0;
    params.x_clearance_nm = 0;
    params.x_speed_um_per_s = 10000000;
    params.x_acceleration_mm_per_s2 = 10000000;
    for (int i = 0; i < 2000; i++) {
        params.feed_nm = 1000 + i * i * 2;
        params.z_speed_um_per_s = 1000 + (i * 7919) % 200000;
        params.z_acceleration_mm_per_s2 = 10 + (i * 104729) % 5000;
        const double exact = ring_mrpm(params.feed_nm * 1e-6, params.z_speed_um_per_s * 1e-3,
                                       params.z_acceleration_mm_per_s2);
        if (exact < 9e6) { // above, the tick rate decides
            TEST_ASSERT_DOUBLE_WITHIN(2e-3 * exact + 100.0, exact, judge(1000).highest_mrpm);
        }
    }
}

static void test_z_speed_and_acceleration_limit_feed_times_speed(void)
{
    params.feed_nm = 1000000;
    params.z_speed_um_per_s = 20000;
    expect_refused(cam_err_z_speed, 2500000, 41666.7, 20000, 1200000);
    params.z_speed_um_per_s = 10000000;
    params.feed_ramp_turns = 2;
    params.z_acceleration_mm_per_s2 = 500;
    expect_refused(cam_err_z_acceleration, 2500000, 868.06, 500, sqrt(1000.0) * 60000);
    params.z_is_measured = 1;
    TEST_ASSERT_EQUAL_INT(cam_ok, judge(2500000).err);
}

/// 1.5 kg, 200 000 nm/rad2 rms, 8 N of friction, 20 N s/m of drag at most 150 000 nm/rad; 3000
/// r/min take 29.6 N rms of inertia and 0.94 N of drag.
static void test_continuous_force_limits_the_speed_of_a_force_drive(void)
{
    table.u2_rms_nm_per_rad2 = 200000;
    params.servo_continuous_mn = 20000;
    params.servo_force_limit_mn = 600000;
    params.servo_mass_g = 1500;
    params.servo_friction_mn = 8000;
    params.servo_drag_mn_s_per_m = 20000;
    TEST_ASSERT_EQUAL_INT(cam_ok, judge(3000000).err); // U takes positions
    params.servo_crossover_hz = 400;
    const double w = omega(3000000);
    const double inertia = 1.5 * 0.2e-3 * w * w;
    const double drag = 20.0 * 0.15e-3 * w;
    const double needed = sqrt(inertia * inertia + drag * drag + 64.0);
    const double highest = omega(1.0);
    const double w_most = sqrt(sqrt(400.0 - 64.0) / 0.3e-3); // without the drag, 0.1 % of it
    expect_refused(cam_err_servo_continuous, 3000000, 1e3 * needed, 20000, w_most / highest);
    params.amplitude_ppm = 500000;
    TEST_ASSERT_EQUAL_INT(cam_ok, judge(3000000).err);
    params.servo_force_limit_mn = 15000;
    TEST_ASSERT_EQUAL_INT(cam_err_servo_continuous, judge(3000000).err);
}

static void test_tick_rate_limits_knots_and_counts_per_tick(void)
{
    table.u.log2_knots = 12;
    table.u.log2_repeat = 2;
    expect_refused(cam_err_tick_rate, 2500000, 2500000, 20000.0 * 8 * 60000 / 16384,
                   20000.0 * 8 * 60000 / 16384);
    table.u.log2_knots = 3;
    const cam_feasibility_t why = cam_feasible(&table, &params, 5000000, 500);
    TEST_ASSERT_EQUAL_INT(cam_err_tick_rate, why.err);
    TEST_ASSERT_EQUAL_INT64(500 * 60000 / 8, why.limit);
}

/// Equal-volume turning, MATHS.md (25): ratio up to 1.4995, acceleration 1.056 453 557 / rad.
static void test_modulation_limits_peak_speed_and_spindle_acceleration(void)
{
    table.ratio_max_q20 = (uint32_t)(1.499457112 * CAM_TABLE_RATIO_ONE) + 1u;
    table.spindle_peak_ppm_per_rad = 1056454u;
    params.spindle_acceleration_mrad_per_s2 = 2000000000;
    params.spindle_limit_mrpm = 2500000;
    TEST_ASSERT_EQUAL_UINT32(2500001, cam_feasible_peak_mrpm(&table, 1667270));
    expect_refused(cam_err_spindle_speed, 2000000, 2000000 * 1.499457112, 2500000, 1667270);
    params.spindle_limit_mrpm = 60000000;
    params.spindle_acceleration_mrad_per_s2 = 500000;
    TEST_ASSERT_EQUAL_INT(cam_ok, judge(207000).err);
    expect_refused(cam_err_spindle_acceleration, 800000, 7414.6e3, 500000, 207745);
    params.z_speed_um_per_s = 20000;
    params.feed_nm = 10000000;
    params.spindle_acceleration_mrad_per_s2 = 2000000000;
    expect_refused(cam_err_z_speed, 100000, 100.0 / 60 * 1.499457 * 10000, 20000, 80028.98);
}

/// The reported highest speed is feasible itself, at slow speeds and small limits as well.
static void test_highest_speed_passes_where_numbers_are_small(void)
{
    for (int32_t limit = 100; limit < 2000; limit += 7) {
        params.u_acceleration_mm_per_s2 = limit;
        const cam_feasibility_t why = judge(60000000);
        TEST_ASSERT_EQUAL_INT(cam_ok, judge(why.highest_mrpm).err);
        const double rpm = 60.0 / (2.0 * pi) * sqrt(limit / 0.3) * 1000.0;
        TEST_ASSERT_DOUBLE_WITHIN(0.003 * rpm, rpm, why.highest_mrpm);
    }
}

/// The verdict alone and the two searches are what the full judgement consists of.
static void test_verdict_and_searches_agree_with_the_full_judgement(void)
{
    params.z_acceleration_mm_per_s2 = 20;
    params.u_acceleration_mm_per_s2 = 20000;
    for (uint32_t mrpm = 100000; mrpm <= 6100000; mrpm += 250000) {
        const cam_feasibility_t all = judge(mrpm);
        TEST_ASSERT_EQUAL_INT(all.err, cam_feasible_check(&table, &params, mrpm, 20000));
        TEST_ASSERT_EQUAL_UINT32(all.highest_mrpm,
                                 cam_feasible_highest_mrpm(&table, &params, 20000));
        TEST_ASSERT_EQUAL_UINT32(all.largest_feed_nm,
                                 cam_feasible_largest_feed_nm(&table, &params, mrpm, 20000));
        TEST_ASSERT_EQUAL(mrpm <= all.highest_mrpm, all.err == cam_ok);
    }
}

static void test_flat_table_has_a_finite_highest_speed(void)
{
    table.u1_peak_nm_per_rad = 0;
    table.u2_peak_nm_per_rad2 = 0;
    table.u_max_nm = 0;
    const cam_feasibility_t good = judge(2500000);
    TEST_ASSERT_EQUAL_INT(cam_ok, good.err);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(60000000, good.highest_mrpm);
}

static void test_largest_demands_do_not_overflow(void)
{
    table.u1_peak_nm_per_rad = INT32_MAX;
    table.u2_peak_nm_per_rad2 = INT32_MAX;
    params.amplitude_ppm = 1250000;
    table.feed_nm = 10000000;
    const cam_feasibility_t why = judge(60000000);
    TEST_ASSERT_EQUAL_INT(cam_err_u_speed, why.err);
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * 1.25 * 2147483647.0 * 6283.185 / 1e3,
                              1.25 * 2147483647.0 * 6283.185 / 1e3, (double)why.needed);
}

/// No speed helps where an axis is missing.
static void test_tool_that_must_swing_is_refused_at_any_speed(void)
{
    table.is_swung = true;
    table.angle = table.u;
    const cam_feasibility_t found = cam_feasible(&table, &params, 1000, 50000);
    TEST_ASSERT_EQUAL_INT(cam_err_swing_axis, found.err);
    TEST_ASSERT_EQUAL_UINT32(0u, found.highest_mrpm);
}
