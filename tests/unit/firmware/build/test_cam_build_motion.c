// SPDX-License-Identifier: Apache-2.0
// Limits of motions by time and of the commands of the axes, against their formulas in double.
#include "cam_build.h"
#include "cam_feasible.h"
#include "hal_host.h"
#include "unity.h"
#include <math.h>

enum { clock_hz = 200000000 };

static const double pi = 3.14159265358979323846;
static const uint32_t rates_hz[] = {1000, 20000, 100000};
static cam_params_t params;
static cam_config_t config;
static uint32_t hz;
static double ticks; // from plan to plan

void setUp(void)
{
    hal_host_reset(20000);
    params = cam_param_defaults();
    params.x_speed_um_per_s = 70000;
    params.z_speed_um_per_s = 90000;
    params.x_acceleration_mm_per_s2 = 1500;
    params.z_acceleration_mm_per_s2 = 2500;
}

static void build(uint32_t rate_hz)
{
    hz = rate_hz;
    hal_host_reset(hz);
    params.observer_bandwidth_mHz = hz < 20000u ? 40000 : 200000;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_build_config(&config, &params, NULL, 0, hz, clock_hz).err);
    ticks = config.play.plan_ticks;
}

static void expect_near(double wanted, double got)
{
    TEST_ASSERT_DOUBLE_WITHIN(1e-6 * fabs(wanted) + 3.0, wanted, got);
}

/// @return [nm / 1024 per tick]
static double speed_q10(int32_t um_per_s)
{
    return um_per_s * 1024e3 / hz;
}

/// @return [nm / 1024 per tick^2]
static double acceleration_q10(int32_t mm_per_s2)
{
    return mm_per_s2 * 1024e6 / hz / hz;
}

/// Out of the cut axes take a quarter, and the whole where they leave the work; U by ticks, X and Z
/// by plans; the window is that of their jerk.
static void test_limits_are_those_of_the_parameters_per_step(void)
{
    for (int i = 0; i < 3; i++) {
        build(rates_hz[i]);
        const int32_t speeds[] = {params.u_speed_um_per_s, params.x_speed_um_per_s,
                                  params.z_speed_um_per_s};
        const int32_t accelerations[] = {params.u_acceleration_mm_per_s2,
                                         params.x_acceleration_mm_per_s2,
                                         params.z_acceleration_mm_per_s2};
        for (uint32_t axis = 0; axis < hal_n_axes; axis++) {
            const double n = axis == hal_axis_u ? 1.0 : ticks;
            const double v = speed_q10(speeds[axis]);
            const double a = acceleration_q10(accelerations[axis]);
            const cam_motion_limits_t *leave = &config.play.leave[axis];
            const cam_motion_limits_t *approach = &config.play.approach[axis];
            const double rounded = n * n + 1.0; // what is cut off a tick counts per plan
            TEST_ASSERT_DOUBLE_WITHIN(n + 1.0, v * n, leave->speed_q10);
            TEST_ASSERT_DOUBLE_WITHIN(rounded, a * n * n, leave->acceleration_q10);
            TEST_ASSERT_DOUBLE_WITHIN(n + 1.0, (floor(v / 4.0) + 1.0) * n, approach->speed_q10);
            TEST_ASSERT_DOUBLE_WITHIN(rounded, (floor(a / 4.0) + 1.0) * n * n,
                                      approach->acceleration_q10);
            const uint32_t log2 = cam_gains_log2_window(&params, (hal_axis_t)axis, hz);
            TEST_ASSERT_EQUAL_UINT32(log2, leave->log2_window);
            TEST_ASSERT_EQUAL_UINT32(log2, approach->log2_window);
            TEST_ASSERT_EQUAL_UINT32(log2, config.play.jog.limits[axis].log2_window);
        }
        expect_near(speed_q10(params.u_speed_um_per_s), config.guard.u.speed_q10);
        expect_near(acceleration_q10(params.u_acceleration_mm_per_s2),
                    config.guard.u.acceleration_q10);
    }
}

/// Slower than allowed is safe: what no word holds is limited to 2^29 per step, and with a window
/// of n steps to 2^30 / n.
static void test_limits_are_limited_to_their_words(void)
{
    params.x_acceleration_mm_per_s2 = 1000000;
    params.z_acceleration_mm_per_s2 = 1000000;
    params.x_speed_um_per_s = 10000000;
    params.x_jerk_m_per_s3 = 100000;
    build(500);
    const cam_motion_limits_t *x = &config.play.leave[hal_axis_x];
    TEST_ASSERT_EQUAL_INT32(1 << 29, x->speed_q10);
    TEST_ASSERT_EQUAL_INT32((1 << 30) >> 4, x->acceleration_q10);
    params.x_jerk_m_per_s3 = 1000000;
    build(500);
    TEST_ASSERT_EQUAL_INT32(1 << 29, x->acceleration_q10);
}

/// @return [counts] what moves the place that X and Z are aimed at from plan to plan
static double unrest(void)
{
    const double ahead = ldexp(config.play.xz_plan_q16, -16);
    const double observed = 1.0 + floor(ldexp(config.spindle.kp_q31, -31) * ahead / 4.0);
    const double alpha = params.spindle_acceleration_mrad_per_s2 / 2000.0 / pi / hz / hz;
    const double halves = floor(2.0 * ahead) + 1.0; // rounded up, as the acceleration
    const double turn = fmin(halves * halves / 4.0 * (alpha + ldexp(1.0, -32)), 1.0);
    const double swung = floor(turn * config.spindle.counts_per_turn) + 1.0;
    return fmin(fmax(observed, config.spindle.jump_window) + swung,
                floor(config.spindle.counts_per_turn / 4.0));
}

static void expect_command(double feed_nm, double x_nm)
{
    for (uint32_t axis = hal_axis_x; axis <= hal_axis_z; axis++) {
        const double way_nm = feed_nm + (axis == hal_axis_x ? x_nm : 0.0);
        const double by_unrest =
            way_nm * unrest() * 1024.0 / (config.spindle.counts_per_turn * ticks);
        const double v = floor(config.play.leave[axis].speed_q10 / ticks);
        const double change = floor(config.play.leave[axis].acceleration_q10 / ticks);
        const double most = v + v / 16.0 + by_unrest + 3072.0;
        const double most_change = 2.0 * (change + by_unrest) + 3072.0;
        TEST_ASSERT_DOUBLE_WITHIN(0.02 * by_unrest + 8.0, most, config.command.vel_q10[axis]);
        TEST_ASSERT_DOUBLE_WITHIN(0.04 * by_unrest + 8.0, most_change,
                                  config.command.change_q10[axis]);
        TEST_ASSERT_EQUAL_INT32(4 * config.play.plan_ticks, config.command.jump_q10[axis]);
    }
}

/// @return [nm] per turn by which X leaves its clearance
static double clearing_nm(void)
{
    const double turns = (double)(config.play.engage_q32 >> 32);
    return config.play.x_clearance_nm * 15.0 / 8.0 / turns;
}

/// X and Z may change by twice their acceleration and by the way of a turn times the unrest of the
/// encoder; X also leaves its clearance, at 15 / 8 of its mean speed over the turns of the ramp.
static void test_command_is_bounded_by_acceleration_and_encoder(void)
{
    for (int i = 0; i < 3; i++) {
        params = cam_param_defaults();
        params.x_clearance_nm = 0;
        params.feed_nm = 1500000;
        build(rates_hz[i]);
        expect_command(config.play.feed_nm, clearing_nm());
        params.x_clearance_nm = 8000000;
        params.engage_turns = 4;
        params.disengage_turns = 7;
        build(rates_hz[i]);
        TEST_ASSERT_EQUAL_INT32(8000000, config.play.x_clearance_nm);
        expect_command(config.play.feed_nm, 8e6 * 15.0 / 8.0 / 4.0);
        params.engage_turns = 5;
        params.disengage_turns = 2;
        params.jump_window_counts = 300;
        params.spindle_acceleration_mrad_per_s2 = 40000000;
        build(rates_hz[i]);
        expect_command(config.play.feed_nm, 8e6 * 15.0 / 8.0 / 2.0);
    }
    // However far a lag makes the controller read ahead of a spindle that is believed to be wild.
    params = cam_param_defaults();
    params.xz_lag_ns = 57608496;
    params.spindle_acceleration_mrad_per_s2 = 2000000000;
    build(2000);
    TEST_ASSERT_EQUAL_DOUBLE(config.spindle.counts_per_turn / 4, unrest());
    expect_command(config.play.feed_nm, clearing_nm());
    // The observer's response, larger than the jump window.
    params.jump_window_counts = 1;
    params.spindle_acceleration_mrad_per_s2 = 10000;
    build(20000);
    TEST_ASSERT_GREATER_THAN(10, unrest());
    expect_command(config.play.feed_nm, clearing_nm());
}

/// A Z that others move is commanded its measured position; X over it follows the measurement.
static void test_z_that_is_measured_is_not_bounded(void)
{
    params.z_is_measured = 1;
    params.feed_nm = 500000;
    build(20000);
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, config.command.vel_q10[hal_axis_z]);
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, config.command.change_q10[hal_axis_z]);
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, config.command.jump_q10[hal_axis_z]);
    TEST_ASSERT_INT32_WITHIN(1, 2 * config.command.vel_q10[hal_axis_x],
                             config.command.change_q10[hal_axis_x]);
    TEST_ASSERT_EQUAL_INT32(32, config.command.jump_q10[hal_axis_x]);
}

/// The retract uses all of U's speed and acceleration, and stops an eighth of the latter before the
/// end of its stroke: it brakes in steps.
static void test_retract_has_the_limits_of_u_and_stops_within_its_stroke(void)
{
    for (int i = 0; i < 3; i++) {
        params.k1_ns = i < 2 ? 742723 : 0;
        params.k2_us2 = i < 2 ? 281448 : 0;
        params.u_stroke_nm = 800000;
        build(rates_hz[i]);
        TEST_ASSERT_EQUAL_MEMORY(&config.play.leave[hal_axis_u], &config.guard.u,
                                 sizeof config.guard.u);
        const int64_t room_nm = config.guard.u.acceleration_q10 / 8192 + 1;
        TEST_ASSERT_EQUAL_INT64((room_nm - 400000) * 1024, config.guard.u_retract_q10);
        TEST_ASSERT_EQUAL_INT64(config.guard.u_retract_q10, config.play.u_retract_q10);
    }
}
