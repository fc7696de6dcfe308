// SPDX-License-Identifier: Apache-2.0
// Every limit with its numbers, against doubles; the reported highest speed is feasible itself.
#include "cam_feasible.h"
#include "unity.h"
#include <math.h>
#include <stdio.h>  // sscanf
#include <string.h> // memcpy, strcmp

static cam_table_t table;
static cam_params_t params;
static const double pi = 3.14159265358979323846;

/// A skirt of 0.3 mm ovality, u' 150 000 nm/rad, u'' 300 000
/// nm/rad2, on a machine without limits.
void setUp(void)
{
    params = cam_param_defaults();
    table = (cam_table_t){
        .u = {.log2_knots = 3, .log2_repeat = 1, .n_slices = 32, .span_nm = 62000000},
        .z_last_nm = 62000000,
        .direction = 1,
        .spindle_mrpm = 2500000,
        .feed_nm = 100000,
        .limit_u_stroke_nm = 2000000,
        .limit_u_speed_um_per_s = 10000000,
        .limit_u_acceleration_mm_per_s2 = 10000000,
        .limit_spindle_mrpm = 60000000,
        .u_max_nm = 150000,
        .ratio_max_q20 = CAM_TABLE_RATIO_ONE,
        .u1_peak_nm_per_rad = 150000,
        .u2_peak_nm_per_rad2 = 300000,
    };
    params.spindle_limit_mrpm = 60000000;
    params.z_speed_um_per_s = 10000000;
    params.z_acceleration_mm_per_s2 = 1000000;
    params.feed_ramp_turns = 100;
    params.u_speed_um_per_s = 10000000;
    params.u_acceleration_mm_per_s2 = 10000000;
}

static cam_refusal_t judge(uint32_t mrpm)
{
    return cam_feasible(&table, &params, mrpm, 20000);
}

/// A speed is refused with these numbers, and the reported highest speed is right to 0.3 %.
static void expect_refused(cam_err_t err, uint32_t mrpm, double needed, double limit,
                           double highest_mrpm)
{
    const cam_refusal_t why = judge(mrpm);
    TEST_ASSERT_EQUAL_INT(err, why.err);
    TEST_ASSERT_EQUAL_UINT32(mrpm, why.speed_mrpm);
    TEST_ASSERT_DOUBLE_WITHIN(0.002 * needed + 1.0, needed, (double)why.needed);
    TEST_ASSERT_DOUBLE_WITHIN(0.6, limit, (double)why.limit);
    TEST_ASSERT_DOUBLE_WITHIN(0.003 * highest_mrpm, highest_mrpm, why.highest_mrpm);
    if (highest_mrpm > 0.0) {
        TEST_ASSERT_EQUAL_INT(cam_ok, judge(why.highest_mrpm).err);
        TEST_ASSERT_EQUAL_INT(err, judge((uint32_t)(highest_mrpm * 1.003)).err);
    }
}

static double omega(double mrpm)
{
    return mrpm * 2.0 * pi / 60000.0;
}

/// Fields of the table that settings may have.
static const struct {
    const char *name;
    void *field; ///< of 32 bits
} fields[] = {
    {"limit_spindle_mrpm", &table.limit_spindle_mrpm},
    {"limit_u_speed_um_per_s", &table.limit_u_speed_um_per_s},
    {"limit_u_acceleration_mm_per_s2", &table.limit_u_acceleration_mm_per_s2},
    {"limit_u_stroke_nm", &table.limit_u_stroke_nm},
    {"u_min_nm", &table.u_min_nm},
    {"u_max_nm", &table.u_max_nm},
    {"u2_rms_nm_per_rad2", &table.u2_rms_nm_per_rad2},
    {"z_last_nm", &table.z_last_nm},
    {"x_slope_ppm", &table.x_slope_ppm},
    {"x_bend_ppm_per_mm", &table.x_bend_ppm_per_mm},
    {"spindle_peak_ppm_per_rad", &table.spindle_peak_ppm_per_rad},
    {"ratio_max_q20", &table.ratio_max_q20},
    {"log2_knots", &table.u.log2_knots},
    {"log2_repeat", &table.u.log2_repeat},
};

/// Change parameters, and fields of the table, by "name=value name=value".
static void apply(const char *settings)
{
    char name[64];
    int value = 0, n = 0;
    for (; sscanf(settings, " %63[^=]=%d%n", name, &value, &n) == 2; settings += n) {
        size_t i = 0;
        while (i < sizeof fields / sizeof fields[0] && strcmp(fields[i].name, name) != 0) {
            i++;
        }
        if (i < sizeof fields / sizeof fields[0]) {
            memcpy(fields[i].field, &value, sizeof value);
        } else {
            TEST_ASSERT_EQUAL_INT_MESSAGE(
                cam_ok, cam_param_set(&params, cam_param_find(name), value), settings);
        }
    }
}

/// The verdict on a speed, with settings.
typedef struct {
    const char *settings;
    uint32_t mrpm;
    cam_err_t err;
    double needed, limit, highest_mrpm;
} limit_t;

static void expect_rows(const limit_t *row, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        setUp();
        apply(row[i].settings);
        TEST_ASSERT_EQUAL_INT_MESSAGE(row[i].err, judge(row[i].mrpm).err, row[i].settings);
        if (row[i].err != cam_ok) {
            expect_refused(row[i].err, row[i].mrpm, row[i].needed, row[i].limit,
                           row[i].highest_mrpm);
        }
    }
}

/// The smaller limit of machine and table counts. Of U the amplitude scales speed and acceleration,
/// the stroke counts to both sides, and a retract that was set starts at the outermost place of the
/// cut; the default one blocks no part that fits. A short ramp would add to the acceleration.
static void test_limits_of_spindle_and_u(void)
{
    const double v = 150.0 * omega(2500e3);
    const double v_most = 30e6 / 150000 * 60000 / (2 * pi);
    const double a = 0.3 * omega(2500e3) * omega(2500e3);
    const double a_most = sqrt(15e9 / 300e3) * 60000 / (2 * pi);
    const limit_t rows[] = {
        {"spindle_limit_mrpm=3000000", 3500000, cam_err_spindle_speed, 3.5e6, 3e6, 3e6},
        {"spindle_limit_mrpm=3000000 limit_spindle_mrpm=2000000", 3500000, cam_err_spindle_speed,
         3.5e6, 2e6, 2e6},
        {"u_speed_um_per_s=30000", 2500000, cam_err_u_speed, v, 30000, v_most},
        {"u_speed_um_per_s=30000 limit_u_speed_um_per_s=15000", 2500000, cam_err_u_speed, v, 15000,
         v_most / 2},
        {"u_speed_um_per_s=30000 amplitude_ppm=500000", 2500000, cam_ok, 0, 0, 0},
        {"u_speed_um_per_s=30000 amplitude_ppm=1250000", 2500000, cam_err_u_speed, 1.25 * v, 30000,
         v_most / 1.25},
        {"u_acceleration_mm_per_s2=15000 engage_turns=100 disengage_turns=100", 2500000,
         cam_err_u_acceleration, a, 15000, a_most},
        {"u_acceleration_mm_per_s2=15000 engage_turns=100 disengage_turns=100 "
         "limit_u_acceleration_mm_per_s2=3750",
         2500000, cam_err_u_acceleration, a, 3750, a_most / 2},
        {"u_max_nm=700000", 1000000, cam_err_u_stroke, 700000, 600000, 0},
        {"u_min_nm=-650000", 1000000, cam_err_u_stroke, 650000, 600000, 0},
        {"limit_u_stroke_nm=200000", 1000000, cam_err_u_stroke, 150000, 100000, 0},
        {"u_retract_nm=-700000", 1000000, cam_err_u_retract, 700000, 600000, 0},
        {"u_retract_nm=-350001 u_min_nm=-250000", 1000000, cam_err_u_retract, 600001, 600000, 0},
        {"u_retract_nm=-350000 u_min_nm=-250000", 1000000, cam_ok, 0, 0, 0},
        {"u_stroke_nm=800000 u_min_nm=-250000 u_max_nm=250000", 1000000, cam_ok, 0, 0, 0},
        {"u_stroke_nm=800000 u_min_nm=-400000 u_max_nm=400000", 1000000, cam_ok, 0, 0, 0},
        {"u_stroke_nm=800000 u_min_nm=-400001 u_max_nm=400000", 1000000, cam_err_u_stroke, 400001,
         400000, 0},
    };
    expect_rows(rows, sizeof rows / sizeof rows[0]);
    params.feed_nm = 1; // the limit of an axis is reported before the turns
    params.spindle_limit_mrpm = 3000000;
    TEST_ASSERT_EQUAL_INT(cam_err_spindle_speed, judge(3500000).err);
}

/// Z has feed times speed and its ramps. X crosses its clearance by the smooth step, 15/8 c n / t
/// and 5.774 c (n / t)^2, in the shorter ramp. A barrel has a slope of 0.2 and a radius of 10 mm.
static void test_limits_of_z_and_x(void)
{
    const double n = 2500.0 / 60.0;
    const double x_most = sqrt(2000.0 / (5.7735 * 100.0)) * 10.0 * 60000.0;
    const double per_n2 = 100.0 * 1e-6 * 1000.0 + 0.2 * 0.1; // [mm] of n^2
    const limit_t rows[] = {
        {"z_last_nm=90000", 100000, cam_err_feed, 100000, 90000, 0},
        {"z_last_nm=90000 z_is_measured=1", 100000, cam_ok, 0, 0, 0},
        {"feed_nm=1000000 z_speed_um_per_s=20000", 2500000, cam_err_z_speed, 1e3 * n, 20000, 12e5},
        {"feed_nm=1000000 feed_ramp_turns=2 z_acceleration_mm_per_s2=500", 2500000,
         cam_err_z_acceleration, 868.06, 500, sqrt(1000.0) * 60000},
        {"feed_nm=1000000 feed_ramp_turns=2 z_acceleration_mm_per_s2=500 z_is_measured=1", 2500000,
         cam_ok, 0, 0, 0},
        {"x_clearance_nm=100000000 x_speed_um_per_s=100000 x_acceleration_mm_per_s2=1000000",
         2500000, cam_err_x_speed, 1.875e5 * n / 10.0, 100000, 100000.0 / 1.875e4 * 60000.0},
        {"x_clearance_nm=100000000 x_speed_um_per_s=10000000 x_acceleration_mm_per_s2=2000",
         2500000, cam_err_x_acceleration, 5.7735 * n * n, 2000, x_most},
        {"x_clearance_nm=100000000 x_speed_um_per_s=10000000 x_acceleration_mm_per_s2=2000 "
         "disengage_turns=5",
         2500000, cam_err_x_acceleration, 4.0 * 5.7735 * n * n, 2000, x_most / 2.0},
        {"x_slope_ppm=200000 x_bend_ppm_per_mm=100000 feed_nm=1000000 feed_ramp_turns=10 "
         "x_clearance_nm=100000 x_speed_um_per_s=8000",
         2500000, cam_err_x_speed, 200.0 * n, 8000, 8000.0 / 200.0 * 60000.0},
        {"x_slope_ppm=200000 x_bend_ppm_per_mm=100000 feed_nm=1000000 feed_ramp_turns=10 "
         "x_clearance_nm=100000 x_speed_um_per_s=10000000 x_acceleration_mm_per_s2=200",
         2500000, cam_err_x_acceleration, per_n2 * n * n, 200, sqrt(200.0 / per_n2) * 60000.0},
    };
    expect_rows(rows, sizeof rows / sizeof rows[0]);
    params.z_is_measured = 1; // others accelerate Z, so only the bend remains
    const double bent = 0.1 * n * n;
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * bent, bent, (double)judge(3000000).needed / 1.44);
}

/// Equal-volume turning, MATHS.md (25): ratio up to 1.4995, acceleration 1.056 453 557 / rad. A
/// force drive of 1.5 kg, 200 000 nm/rad2 rms, 8 N of friction, 20 N s/m of drag at most 150 000
/// nm/rad: 3000 r/min take 29.6 N rms of inertia and 0.94 N of drag.
static void test_limits_of_modulation_ticks_and_force(void)
{
    const double w = omega(3000000);
    const double inertia = 1.5 * 0.2e-3 * w * w;
    const double drag = 20.0 * 0.15e-3 * w;
    const double force = 1e3 * sqrt(inertia * inertia + drag * drag + 64.0);
    const double w_most = sqrt(sqrt(400.0 - 64.0) / 0.3e-3); // without the drag, 0.1 % of it
    const double ticks = 20000.0 * 8 * 60000 / 16384;
    const limit_t rows[] = {
        {"ratio_max_q20=1572295 spindle_peak_ppm_per_rad=1056454 spindle_limit_mrpm=2500000 "
         "spindle_acceleration_mrad_per_s2=2000000000",
         2000000, cam_err_spindle_speed, 2000000 * 1.499457112, 2500000, 1667270},
        {"ratio_max_q20=1572295 spindle_peak_ppm_per_rad=1056454 "
         "spindle_acceleration_mrad_per_s2=500000",
         800000, cam_err_spindle_acceleration, 7414.6e3, 500000, 207745},
        {"ratio_max_q20=1572295 spindle_peak_ppm_per_rad=1056454 "
         "spindle_acceleration_mrad_per_s2=500000",
         207000, cam_ok, 0, 0, 0},
        {"ratio_max_q20=1572295 spindle_peak_ppm_per_rad=1056454 feed_nm=10000000 "
         "z_speed_um_per_s=20000 spindle_acceleration_mrad_per_s2=2000000000",
         100000, cam_err_z_speed, 100.0 / 60 * 1.499457 * 10000, 20000, 80028.98},
        {"log2_knots=12 log2_repeat=2", 2500000, cam_err_tick_rate, 2500000, ticks, ticks},
        {"servo_continuous_mn=20000 servo_force_limit_mn=600000 servo_mass_g=1500 "
         "servo_friction_mn=8000 servo_drag_mn_s_per_m=20000 u2_rms_nm_per_rad2=200000",
         3000000, cam_ok, 0, 0, 0}, // U takes positions
        {"servo_continuous_mn=20000 servo_force_limit_mn=600000 servo_mass_g=1500 "
         "servo_friction_mn=8000 servo_drag_mn_s_per_m=20000 u2_rms_nm_per_rad2=200000 "
         "servo_crossover_hz=400",
         3000000, cam_err_servo_continuous, force, 20000, w_most / omega(1.0)},
    };
    expect_rows(rows, sizeof rows / sizeof rows[0]);
    params.amplitude_ppm = 500000;
    TEST_ASSERT_EQUAL_INT(cam_ok, judge(3000000).err);
    params.servo_force_limit_mn = 15000;
    TEST_ASSERT_EQUAL_INT(cam_err_servo_continuous, judge(3000000).err);
    params.servo_force_limit_mn = 7999; // friction alone
    table.u1_peak_nm_per_rad = table.u2_peak_nm_per_rad2 = table.u2_rms_nm_per_rad2 = 0;
    TEST_ASSERT_EQUAL_INT64(8000, judge(3000000).needed);
    setUp();
    const cam_refusal_t why = cam_feasible(&table, &params, 5000000, 500); // counts per tick
    TEST_ASSERT_EQUAL_INT(cam_err_tick_rate, why.err);
    TEST_ASSERT_EQUAL_INT64(500 * 60000 / 8, why.limit);
    table.ratio_max_q20 = 1572295;
    TEST_ASSERT_EQUAL_UINT32(2500001, cam_feasible_peak_mrpm(&table, 1667270));
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
    const cam_refusal_t why = judge(2500000);
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
    for (int i = 0; i < 2000; i += 4) {
        params.feed_nm = 1000 + i * i * 2;
        params.z_speed_um_per_s = 1000 + (i * 7919) % 200000;
        params.z_acceleration_mm_per_s2 = 10 + (i * 104729) % 5000;
        const double feed_mm = params.feed_nm * 1e-6;
        const double a = params.z_acceleration_mm_per_s2;
        const double v = fmin(params.z_speed_um_per_s * 1e-3, sqrt(feed_mm * a));
        const double exact = 60e3 / (feed_mm / v + fmax(v / a, feed_mm / v / 255.0));
        if (exact < 9e6) { // above, the tick rate decides
            TEST_ASSERT_DOUBLE_WITHIN(2e-3 * exact + 100.0, exact, judge(1000).highest_mrpm);
        }
    }
}

/// The reported highest speed is feasible itself, at slow speeds and small limits as well.
static void test_highest_speed_passes_where_numbers_are_small(void)
{
    for (int32_t limit = 100; limit < 2000; limit += 7) {
        params.u_acceleration_mm_per_s2 = limit;
        const cam_refusal_t why = judge(60000000);
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
        const cam_refusal_t all = judge(mrpm);
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
    TEST_ASSERT_GREATER_THAN_UINT32(2500000, judge(2500000).highest_mrpm);
    table.u1_peak_nm_per_rad = 0;
    table.u2_peak_nm_per_rad2 = 0;
    table.u_max_nm = 0;
    const cam_refusal_t good = judge(2500000);
    TEST_ASSERT_EQUAL_INT(cam_ok, good.err);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(60000000, good.highest_mrpm);
}

static void test_largest_demands_do_not_overflow(void)
{
    table.u1_peak_nm_per_rad = INT32_MAX;
    table.u2_peak_nm_per_rad2 = INT32_MAX;
    params.amplitude_ppm = 1250000;
    table.feed_nm = 10000000;
    const cam_refusal_t why = judge(60000000);
    TEST_ASSERT_EQUAL_INT(cam_err_u_speed, why.err);
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * 1.25 * 2147483647.0 * 6283.185 / 1e3,
                              1.25 * 2147483647.0 * 6283.185 / 1e3, (double)why.needed);
}

/// No speed helps where an axis is missing.
static void test_tool_that_must_swing_is_refused_at_any_speed(void)
{
    table.is_swung = true;
    table.angle = table.u;
    const cam_refusal_t found = cam_feasible(&table, &params, 1000, 50000);
    TEST_ASSERT_EQUAL_INT(cam_err_swing_axis, found.err);
    TEST_ASSERT_EQUAL_UINT32(0u, found.highest_mrpm);
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

/// A short ramp adds to the needs of U, with a modulated spindle more, and of an eccentric disc,
/// whose u is as large as u' and u'', a ramp of any length. A U that stands far off its middle
/// moves there, however little its sections ask for: e u' + e' u is e u'' + 2 e' u' with u' for u''
/// and half of u for u'.
static void test_engaging_is_never_taken_too_small(void)
{
    static const struct {
        const char *name;
        cam_err_t err;
        int32_t u_min_nm, u_max_nm;
        uint32_t u1, u2, spindle_ppm, mrpm;
        int most_turns;
    } rows[] = {
        {"disc", cam_err_u_acceleration, -14800000, 0, 7400000, 8200000, 0, 300000, 100},
        {"offset", cam_err_u_speed, -400000, 0, 10000, 20000, 0, 300000, 20},
        {"oval", cam_err_u_acceleration, 0, 150000, 150000, 300000, 0, 2500000, 10},
        {"modulated", cam_err_u_acceleration, 0, 150000, 150000, 300000, 1500000, 2500000, 10},
    };
    table.limit_u_stroke_nm = 30000000;
    params.u_stroke_nm = 30000000;
    params.disengage_turns = 100;
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const bool is_speed = rows[i].err == cam_err_u_speed;
        table.u_min_nm = rows[i].u_min_nm;
        table.u_max_nm = rows[i].u_max_nm;
        table.u1_peak_nm_per_rad = rows[i].u1;
        table.u2_peak_nm_per_rad2 = rows[i].u2;
        table.spindle_peak_ppm_per_rad = rows[i].spindle_ppm;
        params.u_speed_um_per_s = is_speed ? 100 : 10000000;
        params.u_acceleration_mm_per_s2 = is_speed ? 10000000 : 1000;
        const double u = fmax(-rows[i].u_min_nm, rows[i].u_max_nm);
        const double w = omega(rows[i].mrpm);
        for (int turns = 1; turns <= rows[i].most_turns; turns++) {
            params.engage_turns = turns;
            const double needed = is_speed ? engaging_peak_of(turns, 0.0, u / 2.0, rows[i].u1, 0.0)
                                           : engaging_peak_of(turns, u, rows[i].u1, rows[i].u2,
                                                              rows[i].spindle_ppm * 1e-6);
            const cam_refusal_t why = judge(rows[i].mrpm);
            TEST_ASSERT_EQUAL_INT_MESSAGE(rows[i].err, why.err, rows[i].name);
            const double bound = (double)why.needed * (is_speed ? 1e3 / w : 1e6 / w / w);
            const double most = 1.031 * needed + (is_speed ? 100.0 : 0.0);
            TEST_ASSERT_TRUE_MESSAGE(bound >= 0.9999 * needed && bound <= most, rows[i].name);
        }
    }
}
