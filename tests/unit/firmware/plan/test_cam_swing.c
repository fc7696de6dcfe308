// SPDX-License-Identifier: Apache-2.0
// The swing of the tool: its lines against the table, its return to 0, its drive. test_cam_demand.c
// has what it demands.
#include "cam_plan_inner.h"
#include "fixture_play.h"
#include "fixture_random.h"
#include "unity.h"
#include <math.h>   // fabs
#include <stdlib.h> // abs

#define TURN 4294967296.0
#define PI 3.14159265358979323846

static fixture_play_t f;

void setUp(void)
{
    const fixture_part_t part = fixture_part_swung();
    fixture_play_init(&f, &part);
    f.params.swing_speed_mdeg_per_s = 100000000;
    f.params.swing_acceleration_deg_per_s2 = 10000000;
    f.params.swing_lag_ns = 1250000; // 25 ticks of 50 us
    f.angle.speed_q32 = 214748;      // 60 r/min
    fixture_play_configure(&f);
}

static hal_swing_t line; ///< followed by the drive
static int32_t n_since;  ///< [ticks] since it began

/// One tick, of which the drive sees the set-point that was planned before.
/// @return [turn] where the drive shall be in this tick
static double tick_turn(void)
{
    n_since++;
    if (f.motion.swing.is_new) {
        f.motion.swing.is_new = false;
        line = f.motion.swing.set;
        n_since = 0;
    }
    fixture_play_tick(&f);
    return (line.pos_q32 + (double)line.vel_q32 * n_since) / TURN;
}

static double largest_error_turn(uint32_t n_ticks)
{
    const double lag_ticks = f.config.play.swing.lag_q16 / 65536.0;
    double most = 0.0;
    for (uint32_t i = 0; i < n_ticks; i++) {
        const double scale = f.motion.scale_q30 / 1073741824.0;
        const double set = tick_turn();
        const double pos = ((double)f.angle.pos_q32 + f.angle.speed_q32 * lag_ticks) / TURN;
        double g[3];
        fixture_gamma(2.0 * PI * (pos - floor(pos)), f.want.z_nm, g);
        const double off = fabs(set - scale * g[0] / (2.0 * PI));
        most = off > most ? off : most;
    }
    return most;
}

/// The sagitta is a T^2 / 8, of 4 * 0.35 / 2 pi turns per rad^2 over a plan.
static void test_lines_leave_the_table_by_their_sagitta_at_most(void)
{
    TEST_ASSERT_TRUE(fixture_play_bring(&f, cam_state_cutting));
    (void)largest_error_turn(200);
    const double way_rad = 2.0 * PI * f.angle.speed_q32 / TURN * FIXTURE_PLAN_TICKS;
    const double chord_turn = 4.0 * 0.35 / (2.0 * PI) * way_rad * way_rad / 8.0;
    TEST_ASSERT_DOUBLE_WITHIN(0.05 * chord_turn, chord_turn, largest_error_turn(40000));
}

static void test_swing_follows_phase_amplitude_and_envelope(void)
{
    f.params.amplitude_ppm = 500000;
    fixture_play_configure(&f);
    TEST_ASSERT_TRUE(fixture_play_bring(&f, cam_state_engaging));
    TEST_ASSERT_TRUE(fixture_play_approach(&f));
    // the envelope moves on within a line, and is that of U's lead
    TEST_ASSERT_TRUE(largest_error_turn(205000) < 2e-5);
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, f.want.state);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.5, f.motion.scale_q30 / 1073741824.0);
}

static void test_swing_nears_zero_within_its_limits_from_anywhere(void)
{
    fixture_random_t random = {.state = 5};
    const cam_play_config_t *cfg = &f.config.play;
    const cam_swing_limits_t *limits = &cfg->swing.gentle;
    for (int k = 0; k < 200 / fixture_rarer; k++) {
        cam_swing_t s = {
            .set = {.pos_q32 = (int32_t)fixture_random_range(&random, -(1 << 29), 1 << 29),
                    .vel_q32 = (int32_t)fixture_random_range(&random, -limits->speed_q32,
                                                             limits->speed_q32)}};
        for (int n = 0; n < 250000 && !s.is_there; n++) {
            const hal_swing_t before = s.set;
            s.is_new = false;
            cam_swing_rest_isr(&s, cfg, limits);
            TEST_ASSERT_TRUE(s.is_new);
            TEST_ASSERT_EQUAL_INT32(before.pos_q32 + before.vel_q32 * cfg->plan_ticks,
                                    s.set.pos_q32);
            TEST_ASSERT_INT32_WITHIN(limits->step_q32, before.vel_q32, s.set.vel_q32);
            TEST_ASSERT_INT32_WITHIN(limits->speed_q32, 0, s.set.vel_q32);
        }
        TEST_ASSERT_TRUE(s.is_there);
        TEST_ASSERT_EQUAL_INT32(0, s.set.vel_q32);
        TEST_ASSERT_INT32_WITHIN(2000, 0, s.set.pos_q32); // 2e-4 degrees
    }
}

/// A plan judges the drive in the tick before its line ends, 7 ticks after the start of the line.
static void test_drive_beyond_its_limit_is_a_fault(void)
{
    const cam_play_config_t *cfg = &f.config.play;
    const cam_swing_t s = {.set = {.pos_q32 = 1000000, .vel_q32 = 1000}};
    const int32_t due_q32 = 1000000 + 1000 * (FIXTURE_PLAN_TICKS - 1) - 1000 * 25;
    const int32_t limit_q32 = 11930465; // one degree
    TEST_ASSERT_EQUAL_INT32(limit_q32, cfg->swing.following_q32);
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        const int32_t end_q32 = due_q32 + sign * limit_q32;
        TEST_ASSERT_EQUAL_HEX32(0, cam_swing_check_isr(&s, cfg, end_q32));
        TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(swing), cam_swing_check_isr(&s, cfg, end_q32 + sign));
    }
}

/// The drive follows its lines, a lag behind, until it is blocked.
static void test_blocked_drive_is_seen_within_one_plan(void)
{
    enum { lag_ticks = 25 };
    int32_t lagged_q32[lag_ticks] = {0};
    TEST_ASSERT_TRUE(fixture_play_bring(&f, cam_state_cutting));
    int32_t beyond = 0; // [ticks] since it is off by more than the limit
    for (uint32_t i = 0; i < 100000u && f.want.faults == 0u; i++) {
        const int32_t set_q32 = (int32_t)llround(tick_turn() * TURN);
        const int32_t due_q32 = lagged_q32[i % lag_ticks];
        lagged_q32[i % lag_ticks] = set_q32;
        f.in.swing_q32 = i < 300u ? due_q32 : f.in.swing_q32;
        const int32_t off_q32 = due_q32 - f.in.swing_q32;
        beyond += abs(off_q32) > f.config.play.swing.following_q32 ? 1 : 0;
    }
    TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(swing), f.want.faults);
    TEST_ASSERT_INT32_WITHIN(FIXTURE_PLAN_TICKS / 2 + 1, FIXTURE_PLAN_TICKS / 2 + 1, beyond);
}

static void test_cut_waits_for_the_swing_to_come_to_rest(void)
{
    f.in.swing_q32 = 1 << 27; // 11 degrees
    fixture_play_tick(&f);
    TEST_ASSERT_EQUAL_INT32(1 << 27, f.motion.swing.set.pos_q32); // off: it follows the tool
    TEST_ASSERT_TRUE(fixture_play_bring(&f, cam_state_ready));
    TEST_ASSERT_TRUE(f.motion.swing.is_there);
    f.motion.swing.is_there = false;
    f.motion.swing.set.pos_q32 = 1 << 27;
    fixture_play_do(&f, cam_request_start);
    for (int i = 0; !f.motion.swing.is_there; i++) {
        TEST_ASSERT_LESS_THAN_INT(100000, i);
        TEST_ASSERT_EQUAL_INT64(f.config.play.u_retract_q10, f.motion.u_target_q10);
        fixture_play_tick(&f);
    }
    TEST_ASSERT_TRUE(fixture_play_approach(&f));
    fixture_play_ticks(&f, 4 * FIXTURE_PLAN_TICKS);
    TEST_ASSERT_FALSE(f.motion.swing.is_there); // it follows the table
}

/// On either side of 0, standing for the moment in which it turns back is not being there.
static void test_swing_that_turns_back_is_not_there(void)
{
    static cam_play_config_t cfg;
    cfg.plan_ticks = 8;
    const cam_swing_limits_t limits = {
        .speed_q32 = 1 << 20, .step_q32 = 1 << 16, .gain_q32 = 1 << 26};
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        cam_swing_t s = {.set = {.pos_q32 = sign * (1 << 27), .vel_q32 = sign * (1 << 16)}};
        cam_swing_rest_isr(&s, &cfg, &limits);
        TEST_ASSERT_EQUAL_INT32(0, s.set.vel_q32);
        TEST_ASSERT_FALSE(s.is_there);
    }
    cam_swing_t still = {0};
    cam_swing_rest_isr(&still, &cfg, &limits);
    TEST_ASSERT_TRUE(still.is_there);
}

/// A spindle that accelerates by alpha is ahead by alpha t^2 / 2 when the line ends: what is aimed
/// at then is what a shape turned back by that would be aimed at without.
static void test_acceleration_of_the_spindle_is_read_ahead(void)
{
    enum { alpha_q40 = 400000000 };
    hal_swing_t aimed[2];
    const double ticks = f.config.play.swing.ahead_q16 / 65536.0;
    const double by_q32 = alpha_q40 / 256.0 * ticks * ticks / 2.0;
    for (int i = 0; i < 2; i++) {
        setUp();
        TEST_ASSERT_TRUE(fixture_play_bring(&f, cam_state_cutting));
        fixture_play_ticks(&f, 100);
        f.motion.alpha_q40 = i == 0 ? alpha_q40 : 0;
        const int32_t turned_q32 = i == 0 ? 0 : -(int32_t)by_q32;
        f.motion.phase_q32 += turned_q32;
        f.config.play.phase_q32 += turned_q32;
        const int32_t before_q32 = f.motion.swing.set.pos_q32;
        for (int k = 0; k < FIXTURE_PLAN_TICKS && f.motion.swing.set.pos_q32 == before_q32; k++) {
            fixture_play_tick(&f);
        }
        aimed[i] = f.motion.swing.set;
    }
    TEST_ASSERT_TRUE(by_q32 > TURN / 100.0);
    TEST_ASSERT_INT32_WITHIN(200, aimed[1].vel_q32, aimed[0].vel_q32);
    f.motion.alpha_q40 = 0;
}
