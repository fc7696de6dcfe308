// SPDX-License-Identifier: Apache-2.0
// Parameters become numbers per tick; one configuration at a time reaches the interrupt.
#include "cam_build.h"
#include "cam_config.h"
#include "unity.h"
#include <math.h>
#include <string.h> // memset

static cam_params_t params;
static cam_config_t config;
static cam_table_t table;
static cam_config_bank_t bank;
static const double turn_q32 = 4294967296.0;

void setUp(void)
{
    params = cam_param_defaults();
    table = (cam_table_t){
        .u = {.log2_knots = 4, .log2_repeat = 1},
        .z_first_nm = -1000000,
        .z_last_nm = 61000000,
        .direction = -1,
        .spindle_mrpm = 2500000,
        .feed_nm = 100000,
        .limit_u_stroke_nm = 1200000,
    };
    memset(&bank, 0, sizeof bank);
}

static void build(uint32_t tick_hz)
{
    TEST_ASSERT_EQUAL_INT(
        cam_ok, cam_build_config(&config, &params, &table, 3000000, tick_hz, 200000000).err);
}

static void expect_share(double wanted, double got)
{
    TEST_ASSERT_DOUBLE_WITHIN(1e-4 * fabs(wanted) + 1.0, wanted, got);
}

static void test_speed_is_turns_per_tick(void)
{
    expect_share(2500.0 / 60.0 / 20000.0 * turn_q32, cam_build_speed_q32(2500000, 20000));
    expect_share(0.005 / 60.0 / 20000.0 * turn_q32, cam_build_speed_q32(5, 20000));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, cam_build_speed_q32(UINT32_MAX, 500));
}

static void test_build_times_and_gains_are_ticks(void)
{
    params.lead_ns = 123456;
    params.xz_lag_ns = 6366198;
    params.k1_ns = 742723;
    params.k2_us2 = 281448;
    for (uint32_t tick_hz = 1000; tick_hz <= 40000u; tick_hz *= 2u) {
        params.observer_bandwidth_mHz = (int32_t)tick_hz * 50;
        build(tick_hz);
        expect_share(123456e-9 * tick_hz * 65536.0, config.play.lead_q16);
        expect_share(6366198e-9 * tick_hz * 65536.0, config.play.xz_lag_q16);
        expect_share(742723e-9 * tick_hz * 65536.0, config.command.configured.k1_q16);
        expect_share((281448e-12 * tick_hz * tick_hz - 1.0 / 48.0) * 65536.0,
                     config.command.configured.k2_q16);
        const double wt = 2.0 * 3.14159265358979 * 0.05;
        expect_share(2.0 * wt * 2147483648.0, config.spindle.kp_q31);
        expect_share(wt * wt * 4294967296.0, config.spindle.ki_q32);
    }
}

/// Parameters are the drawing's angles, the configuration counts in the sense of cutting.
static void test_build_angles_turn_and_wrap(void)
{
    static const int32_t udeg[] = {0, 90000000, -90000000, 180000000, -180000000, 1};
    static const uint32_t wanted[] = {0, 1u << 30, 3u << 30, 1u << 31, 1u << 31, 12};
    for (int i = 0; i < 12; i++) {
        table.direction = i < 6 ? 1 : -1;
        const uint32_t angle_q32 = i < 6 ? wanted[i] : 0u - wanted[i - 6];
        params.phase_udeg = udeg[i % 6];
        params.index_offset_udeg = udeg[i % 6];
        build(20000);
        TEST_ASSERT_EQUAL_HEX32(angle_q32, (uint32_t)config.play.phase_q32);
        const uint32_t half_count = (uint32_t)(turn_q32 / params.counts_per_turn / 2.0);
        TEST_ASSERT_EQUAL_HEX32(angle_q32 + half_count, config.spindle.centre_q32);
    }
}

static void test_build_sense_follows_direction_and_encoder(void)
{
    for (int32_t direction = -1; direction <= 1; direction += 2) {
        for (int32_t sign = -1; sign <= 1; sign += 2) {
            table.direction = direction;
            params.encoder_sign = sign;
            build(20000);
            TEST_ASSERT_EQUAL_HEX32(direction == sign ? 0u : ~0u, config.spindle.sign_mask);
            TEST_ASSERT_EQUAL_INT32(2500000 * direction, config.play.spindle_mrpm);
        }
    }
}

static void test_build_feed_and_speed_of_the_parameters_overrule_the_table(void)
{
    build(20000);
    TEST_ASSERT_EQUAL_INT32(100000, config.play.feed_nm);
    TEST_ASSERT_EQUAL_INT64(622 * (INT64_C(1) << 32), config.play.feed_q32);
    params.feed_nm = 1000000;
    params.spindle_mrpm = 1000000;
    build(20000);
    TEST_ASSERT_EQUAL_INT32(1000000, config.play.feed_nm);
    TEST_ASSERT_EQUAL_INT32(-1000000, config.play.spindle_mrpm);
    TEST_ASSERT_EQUAL_INT64(64 * (INT64_C(1) << 32), config.play.feed_q32);
    TEST_ASSERT_EQUAL_PTR(&config.table, config.play.table);
}

/// A tool that engages from inside the stock would dive into it.
static void test_build_x_keeps_clear_of_the_stock(void)
{
    static const struct {
        int32_t depth_nm, asked_nm, clearance_nm;
    } cases[] = {{999999, 1000000, 1000000},
                 {6000000, 1000000, 6000000},
                 {6000000, 7000000, 7000000},
                 {INT32_MAX, 7000000, 100000000}};
    table.u_min_nm = 0;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        table.depth_nm = (uint32_t)cases[i].depth_nm;
        params.x_clearance_nm = cases[i].asked_nm;
        build(20000);
        TEST_ASSERT_EQUAL_INT32(cases[i].clearance_nm, config.play.x_clearance_nm);
    }
}

/// At envelope 0 the follower stands over the base circle: without the lift it would cut the nose.
static void test_build_cam_keeps_clear_of_its_lobes(void)
{
    static const cam_knot_t some = {0};
    table.u_min_nm = 0;
    build(20000);
    TEST_ASSERT_EQUAL_INT32(1000000, config.play.x_clearance_nm); // a skirt from its long axis
    table.u_min_nm = -8000001;
    params.u_stroke_nm = 24000000;
    table.limit_u_stroke_nm = 24000000;
    build(20000);
    TEST_ASSERT_EQUAL_INT32(11000001, config.play.x_clearance_nm); // a skirt about its mean
    table.angle.knots = &some;
    build(20000);
    TEST_ASSERT_EQUAL_INT32(11000001, config.play.x_clearance_nm); // of 1.25 times its amplitude
    TEST_ASSERT_EQUAL_INT64(-10500001 * INT64_C(1024), config.play.u_retract_q10);
    TEST_ASSERT_EQUAL_INT64(-10500001 * INT64_C(1024), config.guard.u_retract_q10);
}

static void test_build_a_hold_is_compensated_where_there_is_feed_forward(void)
{
    params.observer_bandwidth_mHz = 50000;
    params.k2_us2 = 0;
    build(1000);
    TEST_ASSERT_EQUAL_INT32(0, config.command.configured.k2_q16);
    params.k2_us2 = 20000; // less than the hold of a tick of 1 ms
    build(1000);
    TEST_ASSERT_INT32_WITHIN(1, 1311, config.command.configured.k2_q16);
}

static cam_err_t build_with(cam_param_id_t id, int32_t value, uint32_t tick_hz)
{
    cam_params_t changed = params;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_param_set(&changed, id, value));
    return cam_build_config(&config, &changed, &table, 3000000, tick_hz, 200000000).err;
}

static void test_build_what_does_not_fit_the_tick_rate_is_refused(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, build_with(cam_param_observer_bandwidth_mHz, 1600000, 20000));
    TEST_ASSERT_EQUAL_INT(cam_err_param_tick,
                          build_with(cam_param_observer_bandwidth_mHz, 1600001, 20000));
    TEST_ASSERT_EQUAL_INT(cam_ok, build_with(cam_param_lead_ns, 3090000, 20000));
    TEST_ASSERT_EQUAL_INT(cam_err_param_tick, build_with(cam_param_lead_ns, 3100000, 20000));
    params.u_speed_um_per_s = 10000000; // no gain is too large for such limits (cam_gains.h)
    params.u_acceleration_mm_per_s2 = 100;
    TEST_ASSERT_EQUAL_INT(cam_ok, build_with(cam_param_k1_ns, 100000000, 100000));
    TEST_ASSERT_EQUAL_INT(cam_ok, build_with(cam_param_k2_us2, 81000000, 20000));
    TEST_ASSERT_EQUAL_INT(cam_err_param_tick, build_with(cam_param_k2_us2, 82000000, 20000));
}

static void test_bank_hands_over_one_configuration_at_a_time(void)
{
    TEST_ASSERT_NULL(cam_config_take_isr(&bank)); // nothing was offered ever
    TEST_ASSERT_EQUAL_PTR(&bank.half[0], cam_config_free_half(&bank));
    cam_config_offer(&bank);
    TEST_ASSERT_EQUAL_PTR(&bank.half[0], cam_config_take_isr(&bank));
    cam_config_t *half = cam_config_free_half(&bank);
    TEST_ASSERT_EQUAL_PTR(&bank.half[1], half);
    TEST_ASSERT_EQUAL_PTR(&bank.half[0], cam_config_take_isr(&bank)); // not offered yet
    cam_config_offer(&bank);
    TEST_ASSERT_NULL(cam_config_free_half(&bank)); // not taken yet
    TEST_ASSERT_EQUAL_PTR(half, cam_config_take_isr(&bank));
    TEST_ASSERT_EQUAL_PTR(&bank.half[0], cam_config_free_half(&bank));
}

/// Speed, acceleration and jerk of U, what the feed-forward adds, and what learned values add.
static void test_limits_of_the_command_of_u_follow_from_gains_and_limits(void)
{
    const double most_learned_nm = 1900.0; // when all learned values change at once
    for (int32_t i = 0; i < 64; i++) {
        memset(&config, 0, sizeof config);
        cam_guard_config_t *g = &config.guard;
        g->u_vel_q6 = 64 * (1000 + 37 * i);
        g->u_acc_q6 = 64 * (50 + 3 * i);
        g->u.log2_window = (uint32_t)i % 8u;
        config.command.configured.k1_q16 = (i % 3 - 1) * 65536 * 3 + i;
        config.command.configured.k2_q16 = (i % 5 - 2) * 65536 * 2 - i;
        config.learned.k1_q16 = i % 2 == 0 ? 1000 * i : -1000 * i;
        config.learned.k2_q16 = -500 * i;
        config.command.configured.friction_q14 = 16384 * 100 * i;
        config.learned.friction_q6 = -64 * 30 * i;
        config.learned.chip_q32 = (i % 2 == 0 ? 1 : -1) * (1 << 23) * i;
        config.learned.chip_q6 = -64 * 20 * i;
        g->range_nm = 500000;
        cam_config_learn(&config);
        const double v = g->u_vel_q6 / 64.0;
        const double a = g->u_acc_q6 / 64.0;
        const double j = ldexp(2.0 * a, -(int)g->u.log2_window) + 1.0 / 1024.0;
        const cam_u_gains_t *by = &config.command.configured;
        const cam_u_gains_t *cut = &config.command.in_cut;
        TEST_ASSERT_EQUAL_INT32(by->k1_q16 + config.learned.k1_q16, cut->k1_q16);
        const double k1 = fmax(fabs(by->k1_q16 / 65536.0), fabs(cut->k1_q16 / 65536.0));
        const double k2 = fmax(fabs(by->k2_q16 / 65536.0), fabs(cut->k2_q16 / 65536.0));
        const double friction = 70.0 * i; // its sense may change in one tick
        const double chip = i / 512.0;    // of the set-point
        const double step = (1.0 + chip) * v + k1 * a + k2 * j + 2.0 * friction;
        const double change = (1.0 + chip) * a + k1 * j + 2.0 * k2 * j + 2.0 * friction;
        TEST_ASSERT_DOUBLE_WITHIN(0.6, step + most_learned_nm + 0.5, g->step_nm);
        TEST_ASSERT_DOUBLE_WITHIN(0.6, change + most_learned_nm + 0.5, g->change_nm);
        TEST_ASSERT_DOUBLE_WITHIN(0.6, step + change + most_learned_nm + 0.5, g->change_off_nm);
    }
}

static void test_limits_of_the_command_of_u_fit_their_words(void)
{
    memset(&config, 0, sizeof config);
    config.guard.u_vel_q6 = INT32_MAX;
    config.guard.u_acc_q6 = INT32_MAX;
    config.command.configured.k1_q16 = 100 * 65536;
    cam_config_limit_command(&config);
    TEST_ASSERT_EQUAL_INT32(1 << 29, config.guard.step_nm);
    TEST_ASSERT_EQUAL_INT32(1 << 29, config.guard.change_nm);
    TEST_ASSERT_EQUAL_INT32(1 << 29, config.guard.change_off_nm);
}
