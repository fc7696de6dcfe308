// SPDX-License-Identifier: Apache-2.0
// Demands of the change from slice to slice on U and on the swing, and of a speed channel on the
// spindle, compared with doubles and with the set-points of a simulated cut.
#include "cam_feasible_inner.h" // cam_cut_up
#include "fixture_play.h"
#include "fixture_shaft.h"
#include "unity.h"
#include <math.h>
#include <stdlib.h>

static fixture_play_t f;
static fixture_part_t part;
static const double pi = 3.14159265358979323846;

void setUp(void)
{
    part = fixture_part_short();
}

static cam_refusal_t judge_at(uint32_t mrpm)
{
    return cam_feasible(&f.table, &f.params, mrpm, FIXTURE_PLAY_HZ);
}

static cam_refusal_t judge(void)
{
    return judge_at(2400000); // 40 turns per second
}

static void expect_needed(cam_err_t err, double needed)
{
    const cam_refusal_t why = judge();
    TEST_ASSERT_EQUAL_INT(err, why.err);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * needed + 2.0, needed, (double)why.needed);
}

/// A table whose slices differ by 50 um, by 80 um/rad in slope, and jump by 60 um.
static void init_changing(void)
{
    fixture_play_init(&f, &part);
    f.table.u_change = (cam_change_t){.most = 50000, .per_rad = 80000, .kink = 60000};
    f.table.limit_u_acceleration_mm_per_s2 = 1000;
    f.params.u_acceleration_mm_per_s2 = 1000;
    f.params.engage_turns = 10;
    f.params.disengage_turns = 10;
    f.params.z_speed_um_per_s = 10000000;
}

/// The sum of u'' omega^2, 2 d2u/dz dphi v omega, the jump within a tick, and du/dz a; of the
/// speed, u' omega and du/dz v.
static void test_acceleration_and_speed_of_u_have_all_their_terms(void)
{
    init_changing();
    f.params.feed_nm = 100000;
    f.params.feed_ramp_turns = 1;
    f.params.z_acceleration_mm_per_s2 = 100000;
    const double omega = 80.0 * pi;
    const double rate = 4000000.0 / 100000.0;               // slices per second
    const double rise = 100.0 * 1600.0 * 1000.0 / 100000.0; // slices per second squared
    const double sum = (double)f.table.u2_peak_nm_per_rad2 * 1e-6 * omega * omega +
                       2.0 * 80000e-6 * rate * omega + 60000e-6 * rate * 20000.0 + 50000e-6 * rise;
    expect_needed(cam_err_u_acceleration, sum);
    f.params.amplitude_ppm = 500000;
    expect_needed(cam_err_u_acceleration, sum / 2.0);
    init_changing();
    f.params.feed_nm = 1000000;
    f.params.u_speed_um_per_s = 1000;
    expect_needed(cam_err_u_speed, f.table.u1_peak_nm_per_rad * 1e-3 * omega + 50.0 * 400.0);
}

/// The largest feed is feasible, and one of 0.2 % more is not; likewise the highest speed. Against
/// the stroke neither helps.
static void test_largest_feed_and_highest_speed_are_edges(void)
{
    init_changing();
    f.table.limit_u_acceleration_mm_per_s2 = 40000;
    f.params.u_acceleration_mm_per_s2 = 40000;
    f.params.feed_nm = 500000;
    cam_refusal_t why = judge();
    TEST_ASSERT_EQUAL_INT(cam_err_u_acceleration, why.err);
    TEST_ASSERT_GREATER_THAN_UINT32(10000, why.largest_feed_nm);
    f.params.feed_nm = (int32_t)why.largest_feed_nm;
    TEST_ASSERT_EQUAL_INT(cam_ok, judge().err);
    f.params.feed_nm += f.params.feed_nm / 500;
    TEST_ASSERT_EQUAL_INT(cam_err_u_acceleration, judge().err);
    f.params.feed_nm = 500000;
    TEST_ASSERT_EQUAL_INT(cam_ok, judge_at(why.highest_mrpm).err);
    TEST_ASSERT_EQUAL_INT(cam_err_u_acceleration,
                          judge_at(why.highest_mrpm + why.highest_mrpm / 500u).err);
    f.params.u_stroke_nm = 100000;
    why = judge();
    TEST_ASSERT_EQUAL_INT(cam_err_u_stroke, why.err);
    TEST_ASSERT_EQUAL_UINT32(0, why.largest_feed_nm);
    TEST_ASSERT_EQUAL_UINT32(0, why.highest_mrpm);
}

/// In 2^-26 turn: the swing takes a jump within one of its set-points.
static void test_swing_has_the_same_terms(void)
{
    part = fixture_part_swung();
    fixture_play_init(&f, &part);
    f.table.swing_change = (cam_change_t){.most = 4000000, .per_rad = 3000000, .kink = 5000000};
    f.params.swing_range_mdeg = 30000;
    f.params.swing_speed_mdeg_per_s = 100000000;
    f.params.swing_acceleration_deg_per_s2 = 100;
    f.params.feed_ramp_turns = 100; // longer than the part, so the height limits the ramp
    f.params.feed_nm = 10000;
    const double omega = 80.0 * pi;
    const double deg = 360.0 / 67108864.0;
    const double rate = 400.0 / 500.0; // the channel has three slices
    const double rise = 10.0 * 1600.0 / 100.0 / 500.0;
    const double turning = (double)f.table.swing.second_mdeg_per_rad2 * 1e-3 * omega * omega;
    const double set_points = 20000.0 / FIXTURE_PLAN_TICKS;
    const double feeding =
        2.0 * 3e6 * deg * rate * omega + 5e6 * deg * rate * set_points + 4e6 * deg * rise;
    const cam_refusal_t why = judge();
    TEST_ASSERT_EQUAL_INT(cam_err_swing_acceleration, why.err);
    TEST_ASSERT_DOUBLE_WITHIN(0.003 * feeding + 2e-3 * turning, turning + feeding,
                              (double)why.needed);
    f.table.swing_change = (cam_change_t){0}; // the speed is that of the slope
    f.params.swing_speed_mdeg_per_s = 1000;
    const double first = f.table.swing.first_mdeg_per_rad;
    TEST_ASSERT_TRUE(first > 6000.0); // so that this is sharp
    const cam_refusal_t slow = judge();
    TEST_ASSERT_EQUAL_INT(cam_err_swing_speed, slow.err);
    TEST_ASSERT_DOUBLE_WITHIN(3.0 * omega, (first + 2.0) * omega, (double)slow.needed);
    f.table.ratio_max_q20 = 2u << 20; // now the spindle turns twice as fast as in the mean
    f.params.engage_turns = 100;
    f.params.disengage_turns = 100;
    expect_needed(cam_err_swing_speed, 2.0 * first * omega);
    f.params.swing_speed_mdeg_per_s = 100000000;
    f.table.spindle_peak_ppm_per_rad = 700000;
    expect_needed(cam_err_swing_acceleration, 4.0 * turning + 0.7 * first * 1e-3 * omega * omega);
    f.params.swing_speed_mdeg_per_s = 1000;
    f.table.swing.first_mdeg_per_rad = 0; // the speed is that of the rise, 15/8 of its mean
    f.params.engage_turns = 1;
    expect_needed(cam_err_swing_speed, 2.0 * 1.03 * 15.0 / 8.0 * f.table.swing.most_mdeg * 40.0);
    f.params.swing_range_mdeg = 20000; // of 0.35 rad
    expect_needed(cam_err_swing_range, 350.0 * 180.0 / pi);
}

/// What a part does not have demands nothing; nor does a Z that another controller moves.
static void test_what_is_not_there_demands_nothing(void)
{
    static const cam_err_t errs[] = {cam_err_cam_amplitude,
                                     cam_err_swing_axis,
                                     cam_err_z_stations,
                                     cam_err_override_measured,
                                     cam_err_override_rings,
                                     cam_err_swing_range,
                                     cam_err_swing_speed,
                                     cam_err_swing_acceleration,
                                     cam_err_u_retract,
                                     cam_err_servo_continuous,
                                     cam_err_spindle_acceleration,
                                     cam_err_spindle_loop,
                                     cam_err_spindle_set_point,
                                     cam_err_feed,
                                     cam_err_z_acceleration};
    enum { n_errs = sizeof errs / sizeof errs[0], n_of_z = 2 };
    fixture_play_init(&f, &part);
    for (int32_t is_measured = 0; is_measured <= 1; is_measured++) {
        f.params.z_is_measured = is_measured;
        cam_demands_t axes;
        (void)cam_feasible_demands(&f.table, &f.params, 2400000, FIXTURE_PLAY_HZ, &axes);
        int n_none = 0;
        for (int i = 0; i < n_errs * cam_n_demands; i++) {
            const cam_demand_t *demand = &axes.of[i / n_errs];
            n_none += demand->err == errs[i % n_errs] && demand->needed == 0u ? 1 : 0;
        }
        TEST_ASSERT_EQUAL_INT(is_measured ? n_errs : n_errs - n_of_z, n_none);
    }
}

/// The ovality steps by 20 um between two slices.
static void stepped(double theta, double z_nm, double u[3])
{
    fixture_cosine_oval(theta, z_nm > 450000.0 ? 200000.0 : 0.0, u);
}

/// @return [nm / 64 per tick^2] largest change of U's step in a cut
static int32_t largest_change(void)
{
    TEST_ASSERT_TRUE(fixture_play_bring(&f, cam_state_cutting));
    int32_t last = f.want.u_set_q6;
    int32_t step = 0;
    int32_t most = 0;
    for (uint32_t n = 0; f.want.state == cam_state_cutting && n < 200000u; n++) {
        fixture_play_tick(&f);
        const int32_t change = f.want.u_set_q6 - last - step;
        most = n > 2u && abs(change) > most ? abs(change) : most;
        step = f.want.u_set_q6 - last;
        last = f.want.u_set_q6;
    }
    TEST_ASSERT_EQUAL_INT(cam_state_disengaging, f.want.state);
    return most;
}

/// At the largest feed the acceleration that is played comes within a fifth of the bound. It does
/// not reach it, because the jump does not occur where u'' is largest.
static void test_cut_at_the_largest_feed_stays_within_the_limit(void)
{
    part.u = stepped;
    part.n_slices = 11;
    part.spindle_mrpm = 2500000;
    fixture_play_init(&f, &part);
    f.params.u_acceleration_mm_per_s2 = 40000;
    f.params.feed_nm = 999999;
    f.params.z_speed_um_per_s = 10000000;
    f.params.z_acceleration_mm_per_s2 = 1000000;
    f.params.x_acceleration_mm_per_s2 = 1000000;
    const cam_refusal_t why = cam_feasible(&f.table, &f.params, 2500000, FIXTURE_PLAY_HZ);
    TEST_ASSERT_EQUAL_INT(cam_err_u_acceleration, why.err);
    f.params.feed_nm = (int32_t)why.largest_feed_nm;
    fixture_play_configure(&f);
    const double limit_q6 = 40000.0 * 1e6 * 64.0 / 20000.0 / 20000.0;
    const int32_t most_q6 = largest_change();
    TEST_ASSERT_TRUE(most_q6 <= limit_q6);
    TEST_ASSERT_TRUE(most_q6 >= 0.6 * limit_q6);
}

/// What no speed helps against is refused by its own error.
static void test_parameters_that_do_not_fit_the_table_are_refused(void)
{
    fixture_play_init(&f, &part);
    TEST_ASSERT_EQUAL_INT(cam_ok, judge().err);
    f.params.feed_override_ppm = 900000;
    TEST_ASSERT_EQUAL_INT(cam_ok, judge().err);
    f.table.is_ring_helix = true;
    TEST_ASSERT_EQUAL_INT(cam_err_override_rings, judge().err);
    f.table.is_ring_helix = false;
    f.params.z_is_measured = 1;
    TEST_ASSERT_EQUAL_INT(cam_err_override_measured, judge().err);
    f.table.has_stations = true;
    TEST_ASSERT_EQUAL_INT(cam_err_z_stations, judge().err);
}

/// A loop of 10 rad/s is too slow for the fall of the ratio, 0.75 / rad, at 200 r/min; one of 40
/// rad/s has set-points beyond the highest speed. Without a modulation any loop will do.
static void test_modulation_demands_a_fast_spindle(void)
{
    const double omega = 200.0 * pi / 30.0;
    part = fixture_part_modulated();
    fixture_play_init(&f, &part);
    f.params.spindle_lag_us = 100000;
    f.params.spindle_acceleration_mrad_per_s2 = 2000000000;
    f.params.spindle_limit_mrpm = 60000000;
    const cam_refusal_t slow = judge_at(200000);
    TEST_ASSERT_EQUAL_INT(cam_err_spindle_loop, slow.err);
    TEST_ASSERT_EQUAL_INT64(10000, slow.limit);
    TEST_ASSERT_DOUBLE_WITHIN(20.0, 750.0 * omega, (double)slow.needed);
    TEST_ASSERT_DOUBLE_WITHIN(200.0, 10.0 / 0.75 * 30e3 / pi, slow.highest_mrpm);
    f.params.spindle_lag_us = 25000;
    f.params.spindle_limit_mrpm = 310000; // r is up to 1.425: 285 r/min
    const cam_refusal_t why = judge_at(200000);
    double most = 0.0;
    for (int i = 0; i < 1000; i++) {
        double r[3];
        fixture_ratio(2.0 * pi * i / 1000.0, 0.0, r);
        most = fmax(most, r[0] + omega * 0.025 * r[0] * r[1]);
    }
    TEST_ASSERT_EQUAL_INT(cam_err_spindle_set_point, why.err);
    TEST_ASSERT_DOUBLE_WITHIN(0.003 * 200e3 * most, 200e3 * most, (double)why.needed);
    TEST_ASSERT_EQUAL_INT(cam_ok, judge_at(why.highest_mrpm).err);
    f.params.spindle_lag_us = 1;
    cam_demands_t axes;
    (void)cam_feasible_demands(&f.table, &f.params, 200000, FIXTURE_PLAY_HZ, &axes);
    for (int i = 0; i < cam_n_demands; i++) {
        TEST_ASSERT_TRUE(axes.of[i].err != cam_err_spindle_loop || axes.of[i].limit == 1000000000);
    }
    part = fixture_part_short();
    fixture_play_init(&f, &part);
    f.params.spindle_lag_us = 1000000;
    TEST_ASSERT_EQUAL_INT(cam_ok, judge_at(200000).err);
}

/// What exceeds an integer by rounding only is that integer.
static void test_numbers_are_rounded_up_and_saturate(void)
{
    const struct {
        double v;
        uint64_t up;
    } cases[] = {
        {-1e300, 0},        {-0.5, 0},
        {0.0, 0},           {0.5, 1},
        {1.0, 1},           {1.0 + 0x1p-50, 1},
        {1.0 + 0x1p-30, 2}, {0x1p62, INT64_MAX},
        {1e300, INT64_MAX}, {__builtin_nan(""), INT64_MAX},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        TEST_ASSERT_EQUAL_UINT64(cases[i].up, cam_cut_up(cases[i].v));
    }
    TEST_ASSERT_EQUAL_UINT64(UINT64_C(1) << 61, cam_cut_up(0x1p61));
}
