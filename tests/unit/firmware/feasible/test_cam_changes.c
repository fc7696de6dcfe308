// SPDX-License-Identifier: Apache-2.0
// Changes by the operator in the cut: their numbers per plan, and in play.
#define OWN_SET_UP
#include "cam_feasible.h"
#include "play_bench.h"

static const double plan_s = (double)FIXTURE_PLAN_TICKS / FIXTURE_PLAY_HZ;

void setUp(void)
{
    part = fixture_part_short();
    part.feed_nm = 20000;
    fixture_play_init(&f, &part);
}

/// A feed below a hundredth is a rest; over a measured Z there is no override.
static void test_rates_and_reciprocals_are_rounded_to_nearest(void)
{
    cam_play_config_t c = {.plan_ticks = 1, .spindle_mrpm = 60000};
    cam_params_t p = f.params;
    p.spindle_override_rate_ppm_per_s = 1000000;
    p.spindle_acceleration_mrad_per_s2 = 2000000000;
    for (int32_t ppm = 10000; ppm <= 1500000; ppm += 7919) {
        p.feed_override_ppm = ppm;
        p.spindle_override_ppm = ppm;
        cam_changes_build(&c, &p, FIXTURE_PLAY_HZ);
        const double rate = ppm * 1e-6;
        TEST_ASSERT_EQUAL_INT64(llround(ldexp(rate, 30)), c.feed_rate_q30);
        TEST_ASSERT_EQUAL_INT64(llround(ldexp(1.0 / rate, 24)), c.per_feed_rate_q24);
        TEST_ASSERT_EQUAL_INT64(llround(ldexp(rate, 30)), c.spindle_rate_q30);
        TEST_ASSERT_EQUAL_INT32((1 << 30) / FIXTURE_PLAY_HZ + 1, c.spindle_step_q30);
    }
    for (p.feed_override_ppm = 0; p.feed_override_ppm <= 9999; p.feed_override_ppm += 9999) {
        cam_changes_build(&c, &p, FIXTURE_PLAY_HZ);
        TEST_ASSERT_EQUAL_INT32(0, c.feed_rate_q30);
        TEST_ASSERT_EQUAL_UINT32(0, c.per_feed_rate_q24);
    }
    p.z_is_measured = 1;
    TEST_ASSERT_EQUAL_INT32(1000000, cam_changes_feed_ppm(&p));
}

/// At least a 16th of a nanometre per plan, and at most a quarter of the approach's acceleration.
static void test_step_of_the_trim_is_limited_to_both_sides(void)
{
    cam_play_config_t c = {.plan_ticks = 8};
    c.approach[hal_axis_x].acceleration_q10 = 6400;
    cam_params_t p = f.params;
    static const int32_t steps[][2] = {{1, 1}, {200000, 64 + 16}, {10000000, 101}};
    for (size_t i = 0; i < sizeof steps / sizeof steps[0]; i++) {
        p.x_trim_rate_nm_per_s = steps[i][0];
        p.x_trim_nm = -7;
        cam_changes_build(&c, &p, 320000);
        TEST_ASSERT_EQUAL_INT32(steps[i][1], c.x_trim_step_q4);
        TEST_ASSERT_EQUAL_INT32(-7 * 16, c.x_trim_q4);
    }
}

static void test_trim_moves_x_at_its_rate_and_leaves_the_rest(void)
{
    bring(cam_state_cutting);
    fixture_play_ticks(&f, 2000);
    f.params.x_trim_nm = -12345;
    f.params.x_trim_rate_nm_per_s = 50000;
    fixture_play_configure(&f);
    double off_nm = 0.0;
    for (int i = 0; i < 8000; i++) {
        fixture_play_tick(&f);
        const double x_nm = (double)f.axis[hal_axis_x].pos_q10 / 1024.0;
        const double was_nm = off_nm;
        off_nm = x_nm - fixture_play_x_nm(&f, (double)f.axis[hal_axis_z].pos_q10 / 1024.0);
        TEST_ASSERT_TRUE(i == 0 || fabs(off_nm - was_nm) < 50000.0 / FIXTURE_PLAY_HZ + 1.5);
        TEST_ASSERT_DOUBLE_WITHIN(0.1, fixture_play_u_nm(&f, f.angle.pos_q32, f.want.z_nm),
                                  (double)f.want.u_set_q6 / 64.0);
    }
    TEST_ASSERT_DOUBLE_WITHIN(2.0, -12345.0, off_nm);
}

static void test_spindle_is_led_within_rate_and_acceleration(void)
{
    bring(cam_state_cutting);
    TEST_ASSERT_EQUAL_INT32(2500000, f.want.spindle_mrpm);
    f.params.spindle_override_ppm = 600000;
    f.params.spindle_override_rate_ppm_per_s = 1000000;
    f.params.spindle_acceleration_mrad_per_s2 = 100000; // 955 r/min in a second: 0.382 of the speed
    fixture_play_configure(&f);
    int32_t before_mrpm = f.want.spindle_mrpm;
    for (int i = 0; i < 22000; i++) {
        fixture_play_tick(&f);
        const double change_mrpm = before_mrpm - f.want.spindle_mrpm;
        TEST_ASSERT_TRUE(change_mrpm >= 0.0 && change_mrpm <= 954930.0 * plan_s + 2.0);
        before_mrpm = f.want.spindle_mrpm;
    }
    TEST_ASSERT_EQUAL_INT32(1500000, f.want.spindle_mrpm);
}

/// The modulation keeps its ratio: the means of a turn differ by the override.
static void test_modulated_spindle_keeps_its_ratio(void)
{
    double mean_mrpm[2] = {0.0, 0.0};
    part = fixture_part_modulated();
    part.feed_nm = 20000;
    fixture_play_init(&f, &part);
    bring(cam_state_cutting);
    f.params.spindle_override_rate_ppm_per_s = 1000000;
    for (int i = 0; i < 2; i++) {
        f.params.spindle_override_ppm = i == 0 ? 800000 : 1000000;
        fixture_play_configure(&f);
        fixture_play_ticks(&f, i == 0 ? 6000 : 6240);
        for (int k = 0; k < 480; k++) {
            fixture_play_tick(&f);
            mean_mrpm[i] += f.want.spindle_mrpm / 480.0;
        }
    }
    TEST_ASSERT_DOUBLE_WITHIN(1.6e-3 * part.spindle_mrpm, 0.8 * mean_mrpm[1], mean_mrpm[0]);
}
