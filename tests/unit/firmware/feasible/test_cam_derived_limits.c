// SPDX-License-Identifier: Apache-2.0
// Windows and limits that follow from encoder, spindle, drive and part.
#include "cam_feasible.h"
#include "cam_build.h"
#include "cam_tick.h"
#include "hal_host.h"
#include "unity.h"
#include <math.h>   // floor
#include <stddef.h> // NULL

static cam_params_t params;
static cam_table_t table;

void setUp(void)
{
    hal_host_reset(20000);
    params = cam_param_defaults();
    params.following_limit_nm = 0;
    params.k1_ns = 742723; // 300 Hz, 0.7
    params.k2_us2 = 281448;
    table = (cam_table_t){.u_min_nm = 0, .u_max_nm = 150000};
}

/// Equation (166) in double, with the spindle's acceleration and a hundredth of its speed.
static double window(double counts, double tick_hz)
{
    const double pi = 3.14159265358979;
    const double omega = 2.0 * pi * params.observer_bandwidth_mHz * 1e-3;
    const double lag_rad = 2.0 * params.spindle_acceleration_mrad_per_s2 * 1e-3 / (omega * tick_hz);
    const double ripple = 0.01 * params.spindle_limit_mrpm / 60000.0 / tick_hz;
    return 4.0 + 2.0 * counts * (lag_rad / (2.0 * pi) + ripple);
}

static void test_jump_window_scales_with_encoder_observer_and_tick(void)
{
    static const int32_t counts[] = {64, 10000, 65536, 1000000, 16777216};
    static const int32_t bandwidth_mHz[] = {20000, 50000, 200000};
    static const uint32_t tick_hz[] = {1000, 20000, 100000};
    for (int i = 0; i < 45; i++) {
        params.counts_per_turn = counts[i % 5];
        params.observer_bandwidth_mHz = bandwidth_mHz[i / 5 % 3];
        const uint32_t hz = tick_hz[i / 15];
        const double wanted = window(params.counts_per_turn, hz);
        const double got = cam_derived_limits_jump_counts(&params, hz);
        TEST_ASSERT_DOUBLE_WITHIN(2.0 + 1e-4 * wanted, wanted > 8.0 ? wanted : 8.0, got);
        TEST_ASSERT_TRUE(got >= 0.9999 * wanted); // 2 pi^2 is taken as 987 / 50
    }
}

/// Eight counts and the jitter on the usual machine, a window that was set as it is, and in the
/// extreme no more than its word and a quarter turn.
static void test_jump_window_is_limited(void)
{
    cam_config_t config = {0};
    TEST_ASSERT_EQUAL_INT32(8, cam_derived_limits_jump_counts(&params, 20000));
    params.index_tolerance_counts = 3;
    TEST_ASSERT_EQUAL_INT32(11, cam_derived_limits_jump_counts(&params, 20000));
    params.jump_window_counts = 4;
    TEST_ASSERT_EQUAL_INT32(4, cam_derived_limits_jump_counts(&params, 20000));
    params.jump_window_counts = params.index_tolerance_counts = 0;
    params.counts_per_turn = 16777216;
    params.spindle_acceleration_mrad_per_s2 = 2000000000;
    params.spindle_limit_mrpm = 60000000;
    params.observer_bandwidth_mHz = 1000;
    TEST_ASSERT_EQUAL_INT32(1 << 30, cam_derived_limits_jump_counts(&params, 500));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_build_config(&config, &params, NULL, 0, 500, 200000000).err);
    TEST_ASSERT_EQUAL_INT32(16777216 / 4, config.spindle.jump_window);
}

static void test_following_limit_is_a_tenth_of_the_ovality(void)
{
    static const struct {
        const char *name;
        int32_t u_min_nm, u_max_nm, amplitude_ppm, k1_ns, set_nm, limit_nm;
    } rows[] = {{"0.3 mm", 0, 150000, 1000000, 742723, 0, 30000},
                {"larger amplitude", 0, 150000, 1250000, 742723, 0, 37500},
                {"most, of a lobe", -7500000, 150000, 1000000, 742723, 0, 200000},
                {"least", 0, 10000, 1000000, 742723, 0, 10000},
                {"fastest drive", 0, 10000, 1000000, 1, 0, 10000},
                {"unknown drive", 0, 10000, 1000000, 0, 0, 100000},
                {"set", 0, 150000, 1000000, 742723, 100, 100}};
    TEST_ASSERT_EQUAL_INT32(10000, cam_derived_limits_following_nm(&params, NULL));
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        table.u_min_nm = rows[i].u_min_nm;
        table.u_max_nm = rows[i].u_max_nm;
        params.amplitude_ppm = rows[i].amplitude_ppm;
        params.k1_ns = rows[i].k1_ns;
        params.following_limit_nm = rows[i].set_nm;
        TEST_ASSERT_EQUAL_INT32_MESSAGE(
            rows[i].limit_nm, cam_derived_limits_following_nm(&params, &table), rows[i].name);
    }
}

/// A U that takes forces has no lag of a drive in the cut; else its loop may be weak.
static void test_following_limit_of_a_force_drive_knows_no_k1(void)
{
    params.k1_ns = params.k2_us2 = 0;
    table.u_min_nm = 0;
    table.u_max_nm = 250000;
    TEST_ASSERT_EQUAL_INT32(100000, cam_derived_limits_following_nm(&params, &table));
    hal_host.slow.force.quantum_un = 20000;
    TEST_ASSERT_EQUAL_INT32(50000, cam_derived_limits_following_nm(&params, &table));
    TEST_ASSERT_EQUAL_INT32(100000, cam_derived_limits_following_nm(&params, NULL));
    TEST_ASSERT_EQUAL_INT32(100000, cam_derived_limits_approach_nm(&params, &table, 20000));
    params.following_limit_nm = 700;
    TEST_ASSERT_EQUAL_INT32(700, cam_derived_limits_approach_nm(&params, &table, 20000));
}

/// Approach at 100 mm/s and 62.5 m/s2: the lag, half of it again, and half a tick of the way.
static void test_approach_limit_adds_the_lag_of_the_drive(void)
{
    const double lag_nm = 742723e-9 * 100e6 + 281448e-12 * 62.5e9;
    const double late_nm = 100e-6 / 2.0 * 100e6; // half of the lead
    TEST_ASSERT_INT32_WITHIN(4, (int32_t)(1.5 * lag_nm + late_nm + 100e6 * 25e-6),
                             cam_derived_limits_approach_nm(&params, &table, 20000));
    TEST_ASSERT_INT32_WITHIN(4, (int32_t)(1.5 * lag_nm + late_nm + 100e6 * 500e-6),
                             cam_derived_limits_approach_nm(&params, &table, 1000));
    table.u_max_nm = 1000000; // then that of the cut counts
    TEST_ASSERT_INT32_WITHIN(4, (int32_t)lag_nm + 200000,
                             cam_derived_limits_approach_nm(&params, &table, 20000));
    params.following_limit_nm = 1;
    TEST_ASSERT_INT32_WITHIN(4, (int32_t)lag_nm + 1,
                             cam_derived_limits_approach_nm(&params, &table, 20000));
    params.following_limit_nm = 100;
    TEST_ASSERT_INT32_WITHIN(4, (int32_t)lag_nm + 100,
                             cam_derived_limits_approach_nm(&params, &table, 20000));
    params.u_jog_um_per_s = 200000; // twice the speed of the approach
    TEST_ASSERT_INT32_WITHIN(4, (int32_t)(lag_nm + 742723e-9 * 100e6) + 100,
                             cam_derived_limits_approach_nm(&params, &table, 20000));
    params.u_jog_um_per_s = 1000000; // that of U is the highest
    TEST_ASSERT_INT32_WITHIN(4, (int32_t)(lag_nm + 742723e-9 * 300e6) + 100,
                             cam_derived_limits_approach_nm(&params, &table, 20000));
}

/// What is at the limit is built, what is beyond it is refused, at every rate.
static void test_most_is_the_largest_value_that_is_built(void)
{
    static const cam_param_id_t ids[] = {cam_param_observer_bandwidth_mHz, cam_param_lead_ns,
                                         cam_param_k1_ns, cam_param_k2_us2};
    static const uint32_t tick_hz[] = {500, 1000, 20000, 33333, 100000};
    for (int i = 0; i < 20; i++) {
        const uint32_t hz = tick_hz[i / 4];
        const int32_t most = cam_derived_limits_most(ids[i % 4], hz);
        cam_params_t p = cam_param_defaults();
        p.observer_bandwidth_mHz = 1000;
        p.u_speed_um_per_s = 10000000; // no gain is too large for such limits (cam_feasible.h)
        p.u_acceleration_mm_per_s2 = 100;
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_param_set(&p, ids[i % 4], most));
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_derived_limits_check(&p, hz).err);
        if (cam_param_set(&p, ids[i % 4], most + 1) == cam_ok) {
            TEST_ASSERT_EQUAL_INT(cam_err_param_tick, cam_derived_limits_check(&p, hz).err);
        }
    }
    TEST_ASSERT_EQUAL_INT32(80000, cam_derived_limits_most(cam_param_observer_bandwidth_mHz, 1000));
    TEST_ASSERT_EQUAL_INT32(30000000, cam_derived_limits_most(cam_param_u_stroke_nm, 1000));
    TEST_ASSERT_EQUAL_INT32(0, cam_derived_limits_most(cam_n_params, 1000));
    params.lead_ns = cam_derived_limits_most(cam_param_lead_ns, 20000);
    params.u_scale_latency_ns = 1; // adds to the lead
    TEST_ASSERT_EQUAL_INT(cam_err_param_tick, cam_derived_limits_check(&params, 20000).err);
}

/// @return the smaller of a quotient, rounded down, and the end of the parameter's own range
static int64_t whole(double exact, cam_param_id_t id)
{
    const double most = cam_param_info(id)->max;
    return (int64_t)floor(exact < most ? exact : most);
}

static void test_limits_by_the_tick_are_exact(void)
{
    for (uint32_t hz = 500; hz <= 1000000u; hz += 1 + hz / 97u) {
        const double n = cam_guard_history - 2;
        TEST_ASSERT_EQUAL_INT32(whole((n * 1e9 - 15259.0) / hz, cam_param_lead_ns),
                                cam_derived_limits_most(cam_param_lead_ns, hz));
        TEST_ASSERT_EQUAL_INT32(whole(32766e9 / hz, cam_param_k1_ns),
                                cam_derived_limits_most(cam_param_k1_ns, hz));
        TEST_ASSERT_EQUAL_INT32(whole(32766e12 / hz / hz, cam_param_k2_us2),
                                cam_derived_limits_most(cam_param_k2_us2, hz));
        TEST_ASSERT_EQUAL_INT32(whole(80.0 * hz, cam_param_observer_bandwidth_mHz),
                                cam_derived_limits_most(cam_param_observer_bandwidth_mHz, hz));
    }
}

/// The speeds of X and Z are limited to what the port's outputs pass on, where it names that.
static void test_speeds_of_slow_axes_are_those_of_their_outputs(void)
{
    cam_params_t p = cam_param_defaults();
    TEST_ASSERT_EQUAL_INT32(10000000, cam_derived_limits_most(cam_param_x_speed_um_per_s, 20000));
    hal_host.slow.scale[hal_axis_x].most_um_per_s = 36000;
    hal_host.slow.scale[hal_axis_z].most_um_per_s = 200000;
    TEST_ASSERT_EQUAL_INT32(36000, cam_derived_limits_most(cam_param_x_speed_um_per_s, 20000));
    TEST_ASSERT_EQUAL_INT(cam_err_param_output, cam_derived_limits_check(&p, 20000).err);
    p.x_speed_um_per_s = 36000;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_derived_limits_check(&p, 20000).err);
    p.z_speed_um_per_s = 200001;
    TEST_ASSERT_EQUAL_INT(cam_err_param_output, cam_derived_limits_check(&p, 20000).err);
    p.k1_ns = INT32_MAX; // the tick is judged first
    TEST_ASSERT_EQUAL_INT(cam_err_param_tick, cam_derived_limits_check(&p, 20000).err);
}

static void test_usual_observer_is_a_twentieth_of_a_slow_tick(void)
{
    TEST_ASSERT_EQUAL_INT32(50000, cam_derived_limits_usual_mHz(200000, 1000));
    TEST_ASSERT_EQUAL_INT32(200000, cam_derived_limits_usual_mHz(200000, 4000));
    TEST_ASSERT_EQUAL_INT32(200000, cam_derived_limits_usual_mHz(200000, 100000));
}

/// Braking tick by tick ends up to an eighth of the acceleration beyond the target
/// (cam_move_profile.c). test_cam_build_motion.c has the room for the feed-forward. In a stroke
/// that is shorter than the room U stays where it is.
static void test_retract_leaves_room_to_brake_inside_the_stroke(void)
{
    static const struct {
        uint32_t tick_hz;
        int32_t stroke_nm, retract_nm;
    } rows[] = {{1000, 800000, 400000 - 31251}, {20000, 800000, 400000 - 79}, {1000, 1000, 0}};
    cam_config_t config = {0};
    params.observer_bandwidth_mHz = 50000;
    params.k1_ns = params.k2_us2 = 0;
    for (int i = 0; i < 3; i++) {
        params.u_stroke_nm = rows[i].stroke_nm;
        TEST_ASSERT_EQUAL_INT(
            cam_ok, cam_build_config(&config, &params, NULL, 0, rows[i].tick_hz, 200000000).err);
        TEST_ASSERT_EQUAL_INT64(-rows[i].retract_nm * INT64_C(1024), config.play.u_retract_q10);
        TEST_ASSERT_EQUAL_INT64(config.play.u_retract_q10, config.guard.u_retract_q10);
    }
}

/// 600 Hz and 0.2 % of the counts are 1.6 kHz at 25 counts per tick, 9.6 r/min of 10 000 counts.
static void test_whole_counts_per_tick_do_not_average(void)
{
    static const struct {
        int32_t counts;
        uint32_t mrpm, tick_hz, averaging_mrpm;
    } rows[] = {
        {10000, 3000000, 20000, 2990000}, {10000, 3009500, 20000, 2990000},
        {10000, 2990500, 20000, 2990000}, {10000, 2990000, 20000, 0},
        {10000, 3010000, 20000, 0},       {10000, 120000, 20000, 116000},
        {10000, 116000, 20000, 0},        {4096, 600000, 20000, 0},   // 2.048, a beat of 960 Hz
        {65536, 3000000, 20000, 0},       {10000, 10000, 20000, 0},   // none in most ticks
        {10000, 6000000, 20000, 5990000},                             // a beat of 1.6 kHz at most
        {10000, 180000, 1000, 0},         {10000, 3000000, 1000, 0}}; // no speed averages
    params.observer_bandwidth_mHz = 100000;
    for (uint32_t i = 0; i < 2u * sizeof rows / sizeof rows[0]; i++) {
        params.counts_per_turn = rows[i / 2u].counts;
        hal_host.slow.has_edge_time = i % 2u == 1u; // which needs no averaging
        TEST_ASSERT_EQUAL_UINT32(
            i % 2u == 1u ? 0u : rows[i / 2u].averaging_mrpm,
            cam_derived_limits_averaging_mrpm(&params, rows[i / 2u].mrpm, rows[i / 2u].tick_hz));
    }
}

/// u = 0.075 mm (1 - cos 2 a) has the slope 150 um; a count of 10 000 is 0.628 mrad.
static void test_count_is_the_way_of_u_in_it(void)
{
    table.u1_peak_nm_per_rad = 150000;
    TEST_ASSERT_EQUAL_UINT32(94247, cam_derived_limits_count_pm(&table, 10000));
    TEST_ASSERT_EQUAL_UINT32(14726214, cam_derived_limits_count_pm(&table, 64));
    table.u1_peak_nm_per_rad = UINT32_MAX;
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, cam_derived_limits_count_pm(&table, 64));
    TEST_ASSERT_EQUAL_UINT32(1608495, cam_derived_limits_count_pm(&table, 16777216));
}

/// The form error that the steps of the outputs leave: half of each, of Z by the slope of X, 0.02,
/// and of U, 10 um in 5 mm of height. Without a table, and on a lobe, Z adds nothing.
static void test_form_is_half_of_each_step(void)
{
    static const cam_lobe_t lobe;
    static const cam_table_t nothing;
    static const struct {
        uint32_t steps_pm[hal_n_axes], form_pm, alone_pm;
    } rows[] = {{{0, 0, 0}, 0, 0},
                {{30517, 0, 0}, 15258, 15258},
                {{30517, 6103515, 0}, 3067016, 3067016},
                {{0, 0, 15258789}, 167846, 0},
                {{1000, 2000, 500000000}, 5501500, 1500},
                {{0, 0, 1000}, 11, 0}};
    table = (cam_table_t){
        .x_slope_ppm = 20000, .u_change.most = 1000, .u = {.n_slices = 11, .span_nm = 5000000}};
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        for (uint32_t axis = 0; axis < hal_n_axes; axis++) {
            hal_host.slow.scale[axis].command_pm = rows[i].steps_pm[axis];
        }
        table.lobes = NULL;
        TEST_ASSERT_EQUAL_UINT32(rows[i].form_pm, cam_derived_limits_form_pm(&table));
        TEST_ASSERT_EQUAL_UINT32(rows[i].alone_pm, cam_derived_limits_form_pm(NULL));
        TEST_ASSERT_EQUAL_UINT32(rows[i].alone_pm, cam_derived_limits_form_pm(&nothing));
        table.lobes = &lobe;
        TEST_ASSERT_EQUAL_UINT32(rows[i].alone_pm, cam_derived_limits_form_pm(&table));
    }
    table = (cam_table_t){.x_slope_ppm = UINT32_MAX,
                          .u_change.most = UINT32_MAX,
                          .u = {.n_slices = cam_table_max_slices, .span_nm = 5000000}};
    TEST_ASSERT_EQUAL_UINT32(2000, cam_derived_limits_form_pm(&table)); // a slope of 4 at most
    for (uint32_t axis = 0; axis < hal_n_axes; axis++) {
        hal_host.slow.scale[axis].command_pm = UINT32_MAX;
    }
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, cam_derived_limits_form_pm(&table));
}
