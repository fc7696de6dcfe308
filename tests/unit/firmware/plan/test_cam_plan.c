// SPDX-License-Identifier: Apache-2.0
// The plan: its period, its increments, which arrive exactly, the speed of the spindle.
#include "cam_fix.h"
#include "play_bench.h"
#include <math.h>

#define PI 3.14159265358979323846

/// @return whether the last tick had a plan
static bool is_planned(void)
{
    return f.until_plan == f.config.play.plan_ticks;
}

static void test_plan_comes_every_400_us_or_in_every_tick(void)
{
    static const struct {
        uint32_t tick_hz;
        int32_t ticks;
    } cases[] = {{500, 1},   {1000, 1},  {2500, 1},   {3750, 2},   {5000, 2},
                 {10000, 4}, {20000, 8}, {40000, 16}, {50000, 20}, {100000, 40}};
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        TEST_ASSERT_EQUAL_INT32(cases[i].ticks, cam_plan_ticks(cases[i].tick_hz));
    }
    TEST_ASSERT_EQUAL_INT32(FIXTURE_PLAN_TICKS, f.config.play.plan_ticks);
}

/// Z is aimed at whole nanometres, and all linear motion arrives in the tick of the next plan.
static void test_increments_arrive_exactly(void)
{
    engage();
    int64_t x_q10 = 0;
    int64_t height_q32 = 0;
    int32_t scale_q30 = 0;
    uint32_t n = 0;
    while (f.want.state != cam_state_disengaging) {
        fixture_play_tick(&f);
        if (!is_planned()) {
            continue;
        }
        const int32_t ticks = f.config.play.plan_ticks;
        const cam_motion_t *m = &f.motion;
        if (n > 0u) { // the height of this tick, which was played before the plan
            TEST_ASSERT_EQUAL_INT64(0, f.axis[hal_axis_z].pos_q10 % 1024);
            TEST_ASSERT_EQUAL_INT64(x_q10, f.axis[hal_axis_x].pos_q10);
        }
        x_q10 = m->axis[hal_axis_x].pos_q10 + (int64_t)m->axis[hal_axis_x].vel_q10 * ticks;
        height_q32 = m->height_q32 + (int64_t)m->height_step_q32 * ticks;
        scale_q30 = m->scale_q30 + m->scale_step_q30 * ticks;
        TEST_ASSERT_TRUE(height_q32 >= 0 && height_q32 <= f.config.play.height_max_q32);
        TEST_ASSERT_TRUE(scale_q30 >= 0 && scale_q30 <= INT32_C(1) << 30);
        n++;
    }
    TEST_ASSERT_GREATER_THAN_UINT32(1000, n);
}

static void test_spindle_goes_from_the_ratio_of_one_plan_to_that_of_the_next(void)
{
    part = fixture_part_modulated();
    fixture_play_init(&f, &part);
    f.params.spindle_lag_us = 25000;
    f.params.lead_ns = 100000; // of U: it does not lead the spindle
    fixture_play_configure(&f);
    f.angle.speed_q32 = 715828; // 200 r/min
    bring(cam_state_cutting);
    fixture_play_ticks(&f, 100);
    const cam_play_config_t *cfg = &f.config.play;
    for (int i = 0; i < 6000; i++) {
        const int32_t from_q28 = f.plan.ratio_q28;
        fixture_play_tick(&f);
        if (!is_planned()) {
            TEST_ASSERT_EQUAL_INT32(from_q28, f.plan.ratio_q28);
            continue;
        }
        double r[3]; // at the angle of the spindle itself when the next plan's set-point begins
        const double turn =
            fixture_play_turns(f.angle.pos_q32 + (FIXTURE_PLAN_TICKS + 1) * f.angle.speed_q32);
        const cam_axis_motion_t *z = &f.motion.axis[hal_axis_z];
        const double z_nm = (double)(z->pos_q10 + z->vel_q10 * FIXTURE_PLAN_TICKS) / 1024.0;
        fixture_ratio(2.0 * PI * (turn - floor(turn)), z_nm, r);
        TEST_ASSERT_DOUBLE_WITHIN(2e-6, r[0], ldexp(f.plan.ratio_q28, -28));
        TEST_ASSERT_EQUAL_INT32(cam_speed_mrpm(&cfg->speed, from_q28, f.plan.ratio_q28),
                                f.motion.spindle_mrpm);
        const double step = (double)(f.plan.ratio_q28 - from_q28) / FIXTURE_PLAN_TICKS;
        TEST_ASSERT_DOUBLE_WITHIN(2.0, ldexp(cfg->speed.mean_q32, -20) * step,
                                  (double)f.motion.alpha_q40);
    }
}

/// A stop in any tick is carried out in it, and the next plan lays the end of the cut.
static void test_stop_is_obeyed_in_its_tick_and_laid_by_the_next_plan(void)
{
    for (uint32_t late = 0; late < FIXTURE_PLAN_TICKS; late++) {
        setUp();
        bring(cam_state_cutting);
        fixture_play_ticks(&f, 1000 + late);
        const int64_t end_q32 = f.plan.disengage_at_q32;
        fixture_play_do(&f, cam_request_stop);
        TEST_ASSERT_EQUAL_UINT32(f.n_asked, f.play.request);
        for (int i = 1; i < FIXTURE_PLAN_TICKS && f.plan.disengage_at_q32 == end_q32; i++) {
            TEST_ASSERT_TRUE(f.motion.is_stopping);
            fixture_play_tick(&f);
        }
        TEST_ASSERT_TRUE(f.plan.disengage_at_q32 < end_q32);
        TEST_ASSERT_FALSE(f.motion.is_stopping);
    }
}

static void until(cam_state_t state)
{
    for (uint32_t i = 0; f.want.state != state; i++) {
        TEST_ASSERT_LESS_THAN_UINT32(100000, i);
        fixture_play_tick(&f);
    }
}

/// Until the guard makes it a fault, a spindle that turns back neither engages nor cuts again.
static void test_spindle_that_turns_back_keeps_the_state(void)
{
    for (int is_stopped = 0; is_stopped < 2; is_stopped++) {
        setUp();
        bring(cam_state_cutting);
        if (is_stopped != 0) {
            fixture_play_do(&f, cam_request_stop);
            until(cam_state_disengaging);
            fixture_play_ticks(&f, 100);
        }
        const cam_state_t state = f.want.state;
        const int64_t from_q32 = is_stopped != 0 ? f.plan.disengage_at_q32 : f.plan.feed_at_q32;
        f.angle.speed_q32 = -f.angle.speed_q32;
        for (uint32_t i = 0; f.angle.pos_q32 > from_q32 - CAM_TURN_Q32 / 8; i++) {
            TEST_ASSERT_LESS_THAN_UINT32(100000, i);
            fixture_play_tick(&f);
            TEST_ASSERT_EQUAL_INT(state, f.want.state);
        }
    }
    f.angle.speed_q32 = -f.angle.speed_q32;
    until(cam_state_ready);
}

/// A Z that others move is taken to go on as it went since the last plan, up or down: there the
/// next plan's heights are read.
static void test_measured_z_is_extrapolated_to_the_next_plan(void)
{
    cut_at(437000);
    for (int32_t step_nm = -5; step_nm <= 5; step_nm += 5) {
        for (int i = 0; i < 5 * FIXTURE_PLAN_TICKS; i++) {
            f.in.actual_nm[hal_axis_z] += step_nm;
            fixture_play_tick(&f);
            if (i > 2 * FIXTURE_PLAN_TICKS && is_planned()) {
                const cam_axis_motion_t *z = &f.motion.axis[hal_axis_z];
                const int64_t then_q10 = z->pos_q10 + (int64_t)z->vel_q10 * FIXTURE_PLAN_TICKS;
                const int32_t now_nm = f.in.actual_nm[hal_axis_z];
                TEST_ASSERT_EQUAL_INT64(now_nm + step_nm * FIXTURE_PLAN_TICKS, then_q10 / 1024);
            }
        }
    }
    TEST_ASSERT_EQUAL_HEX32(0, f.want.faults);
}

/// Motions by time of X and Z are filtered: after a cut their filters begin where the axes are.
static void test_a_cut_ends_the_glides_of_the_approach(void)
{
    bring(cam_state_engaging);
    TEST_ASSERT_TRUE(f.motion.is_filtering);
    TEST_ASSERT_TRUE(fixture_play_approach(&f));
    fixture_play_ticks(&f, 2 * FIXTURE_PLAN_TICKS);
    TEST_ASSERT_TRUE(f.motion.is_playing);
    TEST_ASSERT_FALSE(f.motion.is_filtering);
    while (f.want.state != cam_state_ready) {
        fixture_play_tick(&f);
        TEST_ASSERT_FALSE(f.motion.is_playing && f.motion.is_filtering);
    }
    fixture_play_ticks(&f, 2 * FIXTURE_PLAN_TICKS);
    TEST_ASSERT_TRUE(f.motion.is_filtering);
}

/// Wherever the spindle is then, the cut begins on the first whole turn after all that is commanded
/// up to the next plan; one tick is the margin of reading the angle.
static void test_cut_begins_on_the_first_turn_after_the_next_plan(void)
{
    static fixture_play_t before;
    uint32_t n = 0;
    for (bring(cam_state_engaging); !f.motion.is_playing; n++) {
        TEST_ASSERT_LESS_THAN_UINT32(100000, n);
        fixture_play_tick(&f);
    }
    setUp();
    bring(cam_state_engaging);
    fixture_play_ticks(&f, n - 1u);
    before = f;
    for (int64_t i = 0; i < 120; i++) {
        f = before;
        f.angle.pos_q32 += i * (CAM_TURN_Q32 / 120);
        fixture_play_tick(&f);
        TEST_ASSERT_TRUE(f.motion.is_playing);
        const double ticks = f.config.play.commanded_q16 / 65536.0 + f.config.play.plan_ticks;
        const double least = (ticks - 1.01) * f.angle.speed_q32;
        const double found = (double)(f.plan.engage_at_q32 - f.angle.pos_q32);
        TEST_ASSERT_EQUAL_INT64(0, f.plan.engage_at_q32 % CAM_TURN_Q32);
        TEST_ASSERT_TRUE(found >= least);
        TEST_ASSERT_TRUE(found < least + (double)CAM_TURN_Q32 + 2.02 * f.angle.speed_q32);
    }
}
