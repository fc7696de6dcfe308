// SPDX-License-Identifier: Apache-2.0
// How far U is commanded with its feed-forward, against the surface that the table was made of.
#include "cam_feasible_inner.h"
#include "image_bench.h"
#include <math.h>

static cam_params_t params;
static const double pi = 3.14159265358979323846;

static void load(void)
{
    make();
    params = cam_param_defaults();
    params.u_speed_um_per_s = 10000000;
    params.u_acceleration_mm_per_s2 = 10000000;
    params.spindle_limit_mrpm = 6000000;
    params.spindle_acceleration_mrad_per_s2 = 2000000000;
}

static cam_cut_t cut_at(uint32_t mrpm)
{
    return (cam_cut_t){.t = &table,
                       .p = &params,
                       .tick_hz = 20000,
                       .mean_mrpm = mrpm,
                       .peak_mrpm = cam_feasible_peak_mrpm(&table, mrpm)};
}

static uint64_t found_nm(uint32_t mrpm)
{
    const cam_cut_t cut = cut_at(mrpm);
    return cam_command_stroke_demand(&cut).needed;
}

/// @return [nm] command at an angle, where the ovality is largest
static double command_nm(double theta, double omega)
{
    double u[3];
    double r[3] = {1.0, 0.0, 0.0};
    part.u(theta, part.z_last_nm, u);
    if (part.speed != NULL) {
        part.speed(theta, part.z_last_nm, r);
    }
    const double speed = u[1] * r[0] * omega;
    const double acceleration = (u[2] * r[0] * r[0] + u[1] * r[0] * r[1]) * omega * omega;
    return u[0] + params.k1_ns * 1e-9 * speed + params.k2_us2 * 1e-12 * acceleration;
}

/// @return [nm] largest command of all angles at all speeds up to this one
static double exact_nm(uint32_t mrpm)
{
    double most = 0.0;
    for (int i = 1; i <= 50; i++) {
        for (int k = 0; k < 720; k++) {
            const double omega = mrpm * pi / 30000.0 * i / 50.0;
            most = fmax(most, fabs(command_nm(k * pi / 360.0, omega)));
        }
    }
    return most;
}

static void test_peaks_alone_bound_a_command_within_the_stroke(void)
{
    load();
    params.k1_ns = 1000000;
    params.k2_us2 = 500000;
    const double omega = 3000.0 * pi / 30.0;
    const double sum = table.u_max_nm + 1e-3 * omega * table.u1_peak_nm_per_rad +
                       0.5e-6 * omega * omega * table.u2_peak_nm_per_rad2;
    TEST_ASSERT_DOUBLE_WITHIN(0.001 * sum, sum, (double)found_nm(3000000));
    params.amplitude_ppm = 500000;
    TEST_ASSERT_DOUBLE_WITHIN(0.001 * sum, sum / 2.0, (double)found_nm(3000000));
}

/// Drives of every damping: what is found is an upper bound, at most 2 % too large.
static void test_command_beyond_the_stroke_is_bounded_by_the_knots(void)
{
    load();
    params.u_stroke_nm = 1000;
    TEST_ASSERT_EQUAL_UINT64_MESSAGE(0, found_nm(3000000), "without gains");
    for (int hz = 60; hz <= 480; hz *= 2) {
        for (int damping = 1; damping <= 10; damping += 3) {
            params.k1_ns = (int32_t)(damping * 0.2e9 / (2.0 * pi * hz));
            params.k2_us2 = (int32_t)(1e12 / (4.0 * pi * pi * hz * hz));
            for (uint32_t mrpm = 500000; mrpm <= 6000000; mrpm *= 2u) {
                const double exact = exact_nm(mrpm);
                const double found = (double)found_nm(mrpm);
                TEST_ASSERT_TRUE(found >= exact - 1.0);
                TEST_ASSERT_TRUE(found <= 1.02 * exact + 2.0);
            }
        }
    }
}

static void test_modulated_spindle_is_bounded_too(void)
{
    part = fixture_part_modulated();
    load();
    params.u_stroke_nm = 1000;
    params.k1_ns = 1500000;
    params.k2_us2 = 1000000;
    for (uint32_t mrpm = 500000; mrpm <= 2000000; mrpm *= 2u) {
        TEST_ASSERT_TRUE((double)found_nm(mrpm) >= exact_nm(mrpm) - 1.0);
        TEST_ASSERT_TRUE((double)found_nm(mrpm) <= 1.15 * exact_nm(mrpm));
    }
}

/// Where the knots would not fit the arithmetic, and beyond the spindle's limit, the peaks count.
static void test_bound_by_the_peaks_where_the_knots_are_not_read(void)
{
    load();
    params.u_stroke_nm = 1000;
    params.k1_ns = 1000000;
    const uint64_t read = found_nm(3000000);
    params.spindle_limit_mrpm = 2999999;
    TEST_ASSERT_GREATER_THAN_UINT64(read, found_nm(3000000));
    params.spindle_limit_mrpm = 60000000;
    params.k1_ns = 100000000;
    params.k2_us2 = 1000000000;
    TEST_ASSERT_GREATER_THAN_UINT64(34000000, found_nm(3000000));
    TEST_ASSERT_GREATER_THAN_UINT64(34000000 * UINT64_C(300), found_nm(60000000));
}

/// A stroke that holds u, but not its command: the highest speed is where the command fits.
static void test_refused_with_the_numbers(void)
{
    load();
    params.k1_ns = 2480000; // 90 Hz, 0.7
    params.k2_us2 = 3127000;
    params.u_stroke_nm = 310000;
    params.z_acceleration_mm_per_s2 = 1000000;
    const cam_refusal_t f = cam_feasible(&table, &params, 3000000, 20000);
    TEST_ASSERT_EQUAL_INT(cam_err_u_command, f.err);
    TEST_ASSERT_EQUAL_INT64(155000, f.limit);
    TEST_ASSERT_DOUBLE_WITHIN(2.0 + 0.02 * exact_nm(3000000), exact_nm(3000000), (double)f.needed);
    TEST_ASSERT_DOUBLE_WITHIN(3100.0, 155000.0, exact_nm(f.highest_mrpm));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_feasible_check(&table, &params, f.highest_mrpm, 20000));
    TEST_ASSERT_EQUAL_INT(cam_err_u_command,
                          cam_feasible_check(&table, &params, f.highest_mrpm + 1u, 20000));
}

/// u''' of G/4 (1 - cos 2 theta), G = 0.3 mm, is at most 2 G; the quintics between the knots jump
/// in their third derivative, by a few per cent of it. Needed are the peaks, allowed the limits
/// with the jerk of a motion by time: 2 a over a window of 64 ticks, which is not shorter than k1.
static void test_speed_and_acceleration_of_the_command_have_all_their_terms(void)
{
    load();
    TEST_ASSERT_TRUE(table.u3_peak_nm_per_rad3 >= 600000);
    TEST_ASSERT_TRUE(table.u3_peak_nm_per_rad3 <= 1.15 * 600000);
    params.u_speed_um_per_s = 400000;
    params.u_acceleration_mm_per_s2 = 20000;
    params.k1_ns = 2000000;
    params.k2_us2 = 3000000;
    const double k1 = 2e-3;
    const double k2 = 3e-6;
    const double jerk = 2.0 * 20000.0 / (64.0 / 20000.0); // [mm/s3]
    const double omega = 3000.0 * pi / 30.0;
    const double v = 1e-3 * table.u1_peak_nm_per_rad * omega;          // [um/s]
    const double a = 1e-6 * table.u2_peak_nm_per_rad2 * omega * omega; // [mm/s2]
    const double j = 1e-6 * table.u3_peak_nm_per_rad3 * omega * omega * omega;
    const cam_cut_t cut = cut_at(3000000);
    const cam_demand_t speed = cam_command_speed_demand(&cut);
    const double v_most = 400000.0 + 1e3 * (k1 * 20000.0 + k2 * jerk);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * v_most, v_most, (double)speed.limit);
    const double v_needed = v + 1e3 * (k1 * a + k2 * j);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * v_needed, v_needed, (double)speed.needed);
    const cam_demand_t bend = cam_command_acceleration_demand(&cut);
    const double a_most = 20000.0 + k1 * jerk + 2.0 * k2 * jerk * 20000.0;
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * a_most, a_most, (double)bend.limit);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * (a + k1 * j), a + k1 * j, (double)bend.needed);
    params.k1_ns = 0; // there it is that of U
    TEST_ASSERT_DOUBLE_WITHIN(1e-4 * a, a, (double)cam_command_acceleration_demand(&cut).needed);
}

/// 3300 r/min at the full acceleration of U have more jerk than its motions by time, over 64 ticks.
static void test_command_too_fast_is_refused(void)
{
    load();
    params.u_stroke_nm = 2000000;
    params.u_speed_um_per_s = 400000;
    params.u_acceleration_mm_per_s2 = 36500;
    params.z_acceleration_mm_per_s2 = 1000000;
    params.k1_ns = 9000000;
    table.limit_spindle_mrpm = 6000000;
    TEST_ASSERT_EQUAL_INT(cam_err_u_command_acceleration,
                          cam_feasible_check(&table, &params, 3300000, 20000));
    params.k1_ns = 0;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_feasible_check(&table, &params, 3300000, 20000));
}
