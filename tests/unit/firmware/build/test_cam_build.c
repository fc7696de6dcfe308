// SPDX-License-Identifier: Apache-2.0
// What a configuration holds, number by number, of parameters that all differ from one another.
#include "cam_build.h"
#include "hal_host.h"
#include "unity.h"
#include <math.h>

enum { hz = 20000, clock_hz = 200000000, plan = 8 };

static const double turn_q32 = 4294967296.0;
static cam_params_t params;
static cam_config_t config;
static cam_table_t table;

void setUp(void)
{
    hal_host_reset(hz);
    params = cam_param_defaults();
    table = (cam_table_t){
        .u = {.log2_knots = 10,
              .log2_repeat = 1,
              .frac_bits = 6,
              .n_slices = 30,
              .span_nm = 62000000},
        .x = {.value_offset = 1234, .n_slices = 30, .span_nm = 62000000},
        .angle = {.frac_bits = 3, .value_offset = -77, .n_slices = 30, .span_nm = 62000000},
        .z_first_nm = -1000000,
        .z_last_nm = 61000000,
        .x_max_nm = 45000000,
        .direction = 1,
        .spindle_mrpm = 2500000,
        .feed_nm = 100000,
        .limit_u_stroke_nm = 1200000,
    };
}

static void build_at(uint32_t tick_hz)
{
    TEST_ASSERT_EQUAL_INT(
        cam_ok, cam_build_config(&config, &params, &table, 3000000, tick_hz, clock_hz).err);
}

static void build(void)
{
    build_at(hz);
}

static void expect_near(double wanted, double got)
{
    TEST_ASSERT_DOUBLE_WITHIN(1e-6 * fabs(wanted) + 1.0, wanted, got);
}

static void test_speed_is_turns_per_tick(void)
{
    expect_near(2500.0 / 60.0 / hz * turn_q32, cam_build_speed_q32(2500000, hz));
    expect_near(0.005 / 60.0 / hz * turn_q32, cam_build_speed_q32(5, hz));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, cam_build_speed_q32(UINT32_MAX, 500));
}

static void test_times_and_gains_are_ticks(void)
{
    params.lead_ns = 123456;
    params.xz_lag_ns = 6366198;
    params.k1_ns = 742723;
    params.k2_us2 = 281448;
    for (uint32_t tick_hz = 1000; tick_hz <= 40000u; tick_hz *= 2u) {
        params.observer_bandwidth_mHz = (int32_t)tick_hz * 50;
        build_at(tick_hz);
        expect_near(123456e-9 * tick_hz * 65536.0, config.play.lead_q16);
        expect_near(6366198e-9 * tick_hz * 65536.0, config.play.xz_lag_q16);
        expect_near(742723e-9 * tick_hz * 65536.0, config.command.configured.k1_q16);
        expect_near((281448e-12 * tick_hz * tick_hz - 1.0 / 48.0) * 65536.0,
                    config.command.configured.k2_q16);
        const double wt = 0.1 * acos(-1.0);
        expect_near(2.0 * wt * 2147483648.0, config.spindle.kp_q31);
        expect_near(wt * wt * turn_q32, config.spindle.ki_q32);
    }
}

/// test_cam_derived_limits.c has the limits.
static void test_what_does_not_fit_the_tick_rate_is_refused(void)
{
    params.observer_bandwidth_mHz = 1600000;
    build();
    params.observer_bandwidth_mHz++;
    params.stopped_ms *= 2;
    const cam_config_t before = config;
    TEST_ASSERT_EQUAL_INT(cam_err_param_tick,
                          cam_build_config(&config, &params, &table, 3000000, hz, clock_hz).err);
    TEST_ASSERT_EQUAL_MEMORY(&before.guard, &config.guard, sizeof config.guard);
}

/// The hold of a tick of 1 ms is taken off a gain that is smaller than it, but not off none.
static void test_a_hold_is_compensated_where_there_is_feed_forward(void)
{
    params.observer_bandwidth_mHz = 50000;
    params.k2_us2 = 0;
    build_at(1000);
    TEST_ASSERT_EQUAL_INT32(0, config.command.configured.k2_q16);
    params.k2_us2 = 20000;
    build_at(1000);
    TEST_ASSERT_INT32_WITHIN(1, 1311, config.command.configured.k2_q16);
}

/// Parameters are the drawing's angles, the configuration counts in the sense of cutting.
static void test_angles_and_sense_follow_direction_and_encoder(void)
{
    static const int32_t udeg[] = {0, 90000000, -90000000, 180000000, -180000000, 1};
    static const uint32_t wanted[] = {0, 1u << 30, 3u << 30, 1u << 31, 1u << 31, 12};
    for (int i = 0; i < 24; i++) {
        table.direction = i % 2 == 0 ? 1 : -1;
        params.encoder_sign = i % 4 < 2 ? 1 : -1;
        params.phase_udeg = params.index_offset_udeg = udeg[i / 4];
        build();
        const uint32_t angle_q32 = table.direction > 0 ? wanted[i / 4] : 0u - wanted[i / 4];
        TEST_ASSERT_EQUAL_HEX32(angle_q32, (uint32_t)config.play.phase_q32);
        const uint32_t half_count = (uint32_t)(turn_q32 / params.counts_per_turn / 2.0);
        TEST_ASSERT_EQUAL_HEX32(angle_q32 + half_count, config.spindle.centre_q32);
        const bool is_same = table.direction == params.encoder_sign;
        TEST_ASSERT_EQUAL_HEX32(is_same ? 0u : ~0u, config.spindle.sign_mask);
        TEST_ASSERT_EQUAL_INT32(2500000 * table.direction, config.play.spindle_mrpm);
    }
}

/// A tool that engages from inside the stock would dive into it. At envelope 0 the follower of a
/// cam stands over the base circle: without 1.25 times the lift it would cut the nose.
static void test_x_keeps_clear_of_the_stock_and_of_lobes(void)
{
    static const cam_knot_t some = {0};
    static const struct {
        const char *name;
        int32_t depth_nm, asked_nm, u_min_nm;
        bool is_cam;
        int32_t clearance_nm;
    } rows[] = {{"thin stock", 999999, 1000000, 0, false, 1000000},
                {"thick stock", 6000000, 1000000, 0, false, 6000000},
                {"more is asked", 6000000, 7000000, 0, false, 7000000},
                {"most", INT32_MAX, 7000000, 0, false, 100000000},
                {"skirt about its mean", 0, 1000000, -8000001, false, 11000001},
                {"cam", 0, 1000000, -8000001, true, 11000001}};
    params.u_stroke_nm = 24000000;
    table.limit_u_stroke_nm = 24000000;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        table.depth_nm = (uint32_t)rows[i].depth_nm;
        params.x_clearance_nm = rows[i].asked_nm;
        table.u_min_nm = rows[i].u_min_nm;
        table.angle.knots = rows[i].is_cam ? &some : NULL;
        build();
        TEST_ASSERT_EQUAL_INT32_MESSAGE(rows[i].clearance_nm, config.play.x_clearance_nm,
                                        rows[i].name);
    }
    TEST_ASSERT_EQUAL_INT64(-10500001 * INT64_C(1024), config.play.u_retract_q10);
    TEST_ASSERT_EQUAL_INT64(-10500001 * INT64_C(1024), config.guard.u_retract_q10);
}

static void test_clock(void)
{
    hal_host.slow.has_edge_time = true;
    build();
    const cam_spindle_config_t *c = &config.spindle;
    TEST_ASSERT_EQUAL_UINT32(10000, c->tick_clocks);
    expect_near(ldexp((double)hz / clock_hz, 27), c->ticks_per_clock_q27);
    TEST_ASSERT_EQUAL_UINT32(100000, c->most_clocks);
    TEST_ASSERT_EQUAL_UINT32(15000, c->late_clocks);
    TEST_ASSERT_EQUAL_UINT32(10000 - 625, c->early_clocks);
    TEST_ASSERT_EQUAL_UINT32(1251, c->on_time_clocks);
    TEST_ASSERT_EQUAL_UINT32(50000, c->stamp_clocks);
    hal_host.slow.has_edge_time = false;
    build();
    TEST_ASSERT_EQUAL_UINT32(0, c->stamp_clocks);
}

static void test_spindle(void)
{
    params.counts_per_turn = 10001;
    params.index_tolerance_counts = 7;
    build();
    const cam_spindle_config_t *c = &config.spindle;
    TEST_ASSERT_EQUAL_INT32(10001, c->counts_per_turn);
    const double count = turn_q32 / 10001.0;
    TEST_ASSERT_EQUAL_UINT32((uint32_t)count, c->turn_per_count_q32);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, count - floor(count), c->turn_per_count_fraction / turn_q32);
    TEST_ASSERT_EQUAL_INT32(7, c->index_tolerance);
    TEST_ASSERT_EQUAL_INT32(11251, c->index_overdue);
    TEST_ASSERT_EQUAL_INT32(2500, c->max_counts);
    TEST_ASSERT_GREATER_THAN_INT32(0, c->jump_window);
    TEST_ASSERT_LESS_OR_EQUAL_INT32(c->max_counts, c->jump_window);
    params.spindle_acceleration_mrad_per_s2 = 2000000000;
    params.spindle_limit_mrpm = 60000000;
    build();
    TEST_ASSERT_LESS_OR_EQUAL_INT32(c->max_counts, c->jump_window);
}

/// Three counts and the tolerance, or the angle in which U moves a micrometre.
static void test_travel_of_a_standing_encoder(void)
{
    table.u1_peak_nm_per_rad = 250000;
    params.counts_per_turn = 1000000;
    build();
    TEST_ASSERT_EQUAL_INT32(3, config.spindle.still_counts);
    expect_near(turn_q32 * 0.004 / (2.0 * acos(-1.0)), config.spindle.still_q32);
    params.counts_per_turn = 10000;
    table.u1_peak_nm_per_rad = 1000000;
    params.index_tolerance_counts = 5;
    build();
    TEST_ASSERT_INT32_WITHIN(8, (int32_t)(turn_q32 * 8e-4), config.spindle.still_q32);
    table.u1_peak_nm_per_rad = 0;
    build();
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, config.spindle.still_q32);
}

static void test_play(void)
{
    params.lead_ns = 120000;
    params.u_scale_latency_ns = 31234;
    params.xz_lag_ns = 70000;
    params.phase_rate_udeg_per_s = 1000000;
    params.amplitude_ppm = 800000;
    params.amplitude_rate_ppm_per_s = 200000;
    params.engage_turns = 7;
    params.disengage_turns = 9;
    params.rehearse_turns = 11;
    params.stopped_mrpm = 6000;
    build();
    const cam_play_config_t *c = &config.play;
    TEST_ASSERT_EQUAL_UINT32(3, config.guard.due_ticks); // 3.0247 ticks
    const double part = 151234e-9 * hz - 3.0;
    TEST_ASSERT_DOUBLE_WITHIN(1.0 / 65536.0, part, config.guard.due_part_q31 / 2147483648.0);
    expect_near(turn_q32 / 360.0 / hz + 1.0, c->phase_step_q32);
    expect_near(0.8 * 1073741824.0, c->amplitude_q30);
    expect_near(0.2 * 1073741824.0 / hz + 1.0, c->amplitude_step_q30);
    TEST_ASSERT_EQUAL_INT64(7 * (INT64_C(1) << 32), c->engage_q32);
    TEST_ASSERT_EQUAL_INT64(9 * (INT64_C(1) << 32), c->disengage_q32);
    TEST_ASSERT_EQUAL_INT64(11 * (INT64_C(1) << 32), c->rehearse_q32);
    expect_near(2147483648.0 / 7.0, c->per_engage_q31);
    expect_near(2147483648.0 / 9.0, c->per_disengage_q31);
    TEST_ASSERT_FALSE(c->is_z_measured);
    TEST_ASSERT_EQUAL_INT32(cam_build_speed_q32(6000, hz), c->turning_q32);
    static const cam_knot_t some = {0};
    table.speed.knots = &some; // what is modulated is not rehearsed
    params.z_is_measured = 1;
    build();
    TEST_ASSERT_EQUAL_INT64(0, c->rehearse_q32);
    TEST_ASSERT_TRUE(c->is_z_measured);
}

static void test_plan(void)
{
    params.lead_ns = 120000;
    params.xz_lag_ns = 200000;
    build();
    const cam_play_config_t *c = &config.play;
    TEST_ASSERT_EQUAL_INT32(plan, c->plan_ticks);
    TEST_ASSERT_EQUAL_INT32((1 << 30) / plan, c->per_plan_q30);
    TEST_ASSERT_EQUAL_INT32((4 + plan) * 65536, c->xz_plan_q16);
    expect_near((2.4 + plan) * 65536.0, c->u_plan_q16);
    TEST_ASSERT_EQUAL_INT32(4 * 65536, c->commanded_q16);
    TEST_ASSERT_EQUAL_INT32((plan + 1) * 65536, c->ratio_q16);
    TEST_ASSERT_EQUAL_INT32(12 * 12 / 2 - 4 * 4 / 4, c->xz_lag2);
    params.lead_ns = 300000;
    build();
    TEST_ASSERT_EQUAL_INT32(6 * 65536, c->commanded_q16);
}

static void test_feed(void)
{
    params.feed_ramp_turns = 3;
    params.z_margin_nm = 54321;
    build();
    const cam_play_config_t *c = &config.play;
    TEST_ASSERT_EQUAL_PTR(&config.table, c->table);
    TEST_ASSERT_EQUAL_INT32(100000, c->feed_nm);
    TEST_ASSERT_EQUAL_INT64(3 * (INT64_C(1) << 32), c->ramp_q32);
    expect_near(2147483648.0 / 3.0, c->per_ramp_q31);
    TEST_ASSERT_EQUAL_INT64(2 * (INT64_C(1) << 32), c->stop_ramp_q32);
    expect_near(2147483648.0 / 2.0, c->per_stop_q31);
    params.z_acceleration_mm_per_s2 = 200; // 0.1 mm per turn at 3000 r/min: 250 mm/s2 in one turn
    table.way_slope_ppm = 1000000;
    build();
    TEST_ASSERT_EQUAL_INT64(3 * (INT64_C(1) << 32), c->stop_ramp_q32);
    params.z_acceleration_mm_per_s2 = 2000;
    params.x_acceleration_mm_per_s2 = 10;
    table.x_slope_ppm = 50000;
    build();
    TEST_ASSERT_EQUAL_INT64(3 * (INT64_C(1) << 32), c->stop_ramp_q32);
    params.x_acceleration_mm_per_s2 = 2000;
    build();
    TEST_ASSERT_EQUAL_INT64(2 * (INT64_C(1) << 32), c->stop_ramp_q32);
    TEST_ASSERT_EQUAL_INT64(623 * (INT64_C(1) << 32), c->feed_q32);
    TEST_ASSERT_EQUAL_INT32(54321, c->z_margin_nm);
    TEST_ASSERT_EQUAL_INT32(-1000000, c->z_first_nm);
    TEST_ASSERT_EQUAL_INT32(-1054321, c->z_low_nm);
    TEST_ASSERT_EQUAL_INT32(61054321, c->z_high_nm);
    params.feed_nm = 900000;
    params.x_trim_nm = -150000;
    build();
    TEST_ASSERT_EQUAL_INT32(900000, c->feed_nm);
    const double turns = 62000000.0 / 900000.0;
    TEST_ASSERT_DOUBLE_WITHIN(2.0, (turns + 3.0) * turn_q32, (double)c->feed_q32);
    TEST_ASSERT_EQUAL_INT64((45000000 - 150000 + (int64_t)c->x_clearance_nm) * 1024,
                            c->x_clear_q10);
    TEST_ASSERT_EQUAL_INT64(1234 * 1024, c->x_offset_q10);
    TEST_ASSERT_EQUAL_INT64(29 * (INT64_C(1) << 32) - 64, c->height_max_q32);
    table.z_last_nm = table.z_first_nm + 10000; // less than half a turn of feed
    build();
    TEST_ASSERT_EQUAL_INT64(INT64_C(1) << 31, c->ramp_q32);
}

static void test_speed(void)
{
    params.spindle_lag_us = 40000;
    build();
    const cam_speed_config_t *c = &config.play.speed;
    TEST_ASSERT_EQUAL_INT32(2500000, c->mean_mrpm);
    TEST_ASSERT_EQUAL_INT32(2500000, config.play.spindle_mrpm);
    TEST_ASSERT_EQUAL_INT32(3000000, c->limit_mrpm);
    TEST_ASSERT_EQUAL_INT32(1, c->sense);
    TEST_ASSERT_EQUAL_INT32(100 * 65536, c->lag_q16); // plans
    TEST_ASSERT_EQUAL_INT32(cam_build_speed_q32(2500000, hz), c->mean_q32);
    params.spindle_mrpm = 2000000;
    table.direction = -1;
    build();
    TEST_ASSERT_EQUAL_INT32(2000000, c->mean_mrpm);
    TEST_ASSERT_EQUAL_INT32(-1, c->sense);
    TEST_ASSERT_EQUAL_INT32(-2000000, config.play.spindle_mrpm);
    params.observer_bandwidth_mHz = 50000;
    build_at(1000);
    TEST_ASSERT_EQUAL_INT32(1 << 26, c->mean_q32); // at most a 64th of a turn per tick
}

static void test_swing(void)
{
    params.swing_speed_mdeg_per_s = 400000;
    params.swing_acceleration_deg_per_s2 = 20000;
    params.swing_lag_ns = 200000;
    params.swing_following_limit_mdeg = 1500;
    build();
    TEST_ASSERT_FALSE(config.play.swing.is_swung);
    table.is_swung = true;
    build();
    const cam_swing_config_t *c = &config.play.swing;
    TEST_ASSERT_TRUE(c->is_swung);
    TEST_ASSERT_EQUAL_INT32(4 * 65536, c->lag_q16);
    TEST_ASSERT_EQUAL_INT32((4 + plan + 1) * 65536, c->ahead_q16);
    TEST_ASSERT_EQUAL_INT32(13 * 13 / 2, c->ahead2);
    expect_near(1.5 / 360.0 * turn_q32, c->following_q32);
    TEST_ASSERT_EQUAL_INT32(1 << 28, c->unit_q30);
    TEST_ASSERT_EQUAL_INT32(-77 * 16, c->offset_q30);
    const double speed = 400.0 / 360.0 / hz * turn_q32;
    const double step = 20000.0 / 360.0 * plan / hz / hz * turn_q32;
    expect_near(speed, c->full.speed_q32);
    expect_near(step, c->full.step_q32);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * step / speed, step / speed / plan,
                              c->full.gain_q32 / turn_q32);
    TEST_ASSERT_LESS_THAN_INT32(c->full.speed_q32, c->gentle.speed_q32);
    TEST_ASSERT_LESS_THAN_INT32(c->full.step_q32, c->gentle.step_q32);
    params.swing_acceleration_deg_per_s2 = 100000000; // with the largest one it brakes, too
    build();
    expect_near(step * 5000.0, c->full.step_q32);
    params.swing_speed_mdeg_per_s = 0;
    build();
    TEST_ASSERT_FALSE(c->is_swung);
}

static void test_guard(void)
{
    params.stopped_ms = 40;
    params.stopped_mrpm = 7000;
    params.u_stroke_nm = 1100000;
    build();
    const cam_guard_config_t *c = &config.guard;
    TEST_ASSERT_EQUAL_INT32(cam_build_speed_q32(3000000, hz), c->overspeed_q32);
    TEST_ASSERT_EQUAL_INT32(cam_build_speed_q32(7000, hz), config.play.turning_q32);
    TEST_ASSERT_EQUAL_UINT32(800, c->stopped_ticks);
    TEST_ASSERT_EQUAL_UINT32(80000, c->homing_ticks);
    const double v_q6 = 64.0 * 400e6 / hz;
    const double a_q6 = 64.0 * 250e9 / hz / hz;
    TEST_ASSERT_DOUBLE_WITHIN(200.0, v_q6 * 17.0 / 16.0, c->u_vel_q6);
    TEST_ASSERT_DOUBLE_WITHIN(200.0, a_q6 * 17.0 / 16.0, c->u_acc_q6);
    TEST_ASSERT_TRUE(c->u_vel_q6 > v_q6 * 17.0 / 16.0 - 1.0);
    TEST_ASSERT_TRUE(c->u_acc_q6 > a_q6 * 17.0 / 16.0 - 1.0);
    TEST_ASSERT_EQUAL_INT32(c->u_acc_q6 + c->u_vel_q6, c->u_acc_off_q6);
    TEST_ASSERT_EQUAL_INT32(550000, c->range_nm);
}

static void test_origin_shifts_all_targets(void)
{
    build();
    const cam_play_config_t was = config.play;
    cam_build_origin(&config, 7, -9);
    TEST_ASSERT_EQUAL_INT64(was.x_clear_q10 + 7168, config.play.x_clear_q10);
    TEST_ASSERT_EQUAL_INT64(was.x_offset_q10 + 7168, config.play.x_offset_q10);
    TEST_ASSERT_EQUAL_INT32(-9, config.play.z_origin_nm);
    TEST_ASSERT_EQUAL_INT32(was.z_low_nm - 9, config.play.z_low_nm);
    TEST_ASSERT_EQUAL_INT32(was.z_high_nm - 9, config.play.z_high_nm);
}

static void test_no_table(void)
{
    params.phase_udeg = 90000000;
    params.encoder_sign = -1;
    config.generation = 4711;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_build_config(&config, &params, NULL, 0, hz, clock_hz).err);
    TEST_ASSERT_NULL(config.play.table);
    TEST_ASSERT_EQUAL_INT64(INT64_C(-500000) * 1024, config.play.u_retract_q10);
    TEST_ASSERT_EQUAL_INT32(1 << 30, config.play.phase_q32); // in the sense of the drawing
    TEST_ASSERT_EQUAL_HEX32(~0u, config.spindle.sign_mask);
    TEST_ASSERT_EQUAL_UINT32(4711, config.generation);
}

/// What the shifts of U make of the largest values is what they are worth.
static void test_scale_of_u(void)
{
    build(); // where the word of the acceleration has room, no bit of it is dropped
    TEST_ASSERT_EQUAL_UINT32(0, config.play.u.a_down);
    TEST_ASSERT_GREATER_THAN_UINT32(0, config.play.u.a_shift);
    static const uint32_t knots[] = {6, 8, 10, 12};
    static const uint32_t fracs[] = {0, 2, 4, 6, 8};
    for (uint32_t i = 0; i < 40u; i++) {
        params.spindle_limit_mrpm = i < 20u ? 3000000 : 4000000; // both sides of a power of 2
        table.u.log2_knots = knots[i % 4u];
        table.u.frac_bits = fracs[i / 4u % 5u];
        table.u.value_offset = 321;
        build();
        const cam_u_scale_t *c = &config.play.u;
        const int frac = (int)table.u.frac_bits;
        const int all = (int)(table.u.log2_knots + table.u.log2_repeat);
        TEST_ASSERT_EQUAL_INT(frac - 4, (int)c->scale_down - (int)c->y_up);
        TEST_ASSERT_EQUAL_INT32(321 * 256 >> c->y_up, c->offset);
        TEST_ASSERT_EQUAL_INT(8 + all - frac, (int)(c->v_up + c->speed_shift));
        TEST_ASSERT_EQUAL_INT(24 + frac + 2 * (int)c->speed_shift - 2 * all,
                              (int)(c->a_shift + c->a_down));
        TEST_ASSERT_LESS_THAN_UINT32(32, c->a_shift);
        TEST_ASSERT_EQUAL_INT(40 - 2 * (int)c->speed_shift + all + (int)c->a_down,
                              (int)c->alpha_shift);
        const uint32_t limit_mrpm = (uint32_t)params.spindle_limit_mrpm;
        const int64_t most_q32 = INT64_C(5) * cam_build_speed_q32(limit_mrpm, hz) / 4;
        const bool is_least = (int)c->speed_shift <= (all > 6 ? all - 6 : 0);
        TEST_ASSERT_TRUE(is_least || most_q32 << c->speed_shift < INT64_C(1) << 30);
        const bool is_most = c->v_up == 0u || c->speed_shift == 20u; // else one more would not fit
        TEST_ASSERT_TRUE(is_most || most_q32 << (c->speed_shift + 1u) >= INT64_C(1) << 30);
    }
}
