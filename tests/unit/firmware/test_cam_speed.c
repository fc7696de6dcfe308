// SPDX-License-Identifier: Apache-2.0
// Ratio, set-point and acceleration of the modulated spindle against doubles; through play: the
// spindle's set-point and the acceleration of U that it causes.
#include "cam_config.h"
#include "cam_speed.h"
#include "fixture_image.h"
#include "fixture_random.h"
#include "unity.h"
#include <math.h>

#define PI 3.14159265358979323846

static fixture_image_t image;
static cam_table_t table;
static cam_params_t params;
static cam_config_t config;

enum { tick_hz = 20000, clock_hz = 10000000 };

void setUp(void)
{
    const fixture_part_t part = fixture_part_modulated();
    fixture_image_make(&image, &part);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_table_check(image.bytes, image.size, &table));
    params = cam_param_defaults();
    params.spindle_lag_us = 25000;
    TEST_ASSERT_EQUAL_INT(cam_ok,
                          cam_config_build(&config, &params, &table, 3000000, tick_hz, clock_hz));
}

void tearDown(void) {}

static void test_ratio_and_slope_are_those_of_the_function(void)
{
    for (int i = 0; i < 4000; i++) {
        const double turn = i / 4000.0;
        const int32_t z_nm = i * 250;
        double r[3];
        fixture_ratio(2.0 * PI * turn, z_nm, r);
        const cam_ratio_t found =
            cam_speed_ratio(&table.speed, (uint32_t)(turn * 4294967296.0), z_nm);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, r[0], ldexp(found.ratio_q28, -28));
        TEST_ASSERT_DOUBLE_WITHIN(2e-4, r[1] * 2.0 * PI, ldexp(found.slope_q20, -20));
    }
}

static cam_speed_t law(const cam_speed_config_t *cfg, cam_ratio_t ratio, int32_t envelope_q30)
{
    const cam_pace_t pace = cam_speed_pace(ratio, envelope_q30);
    return (cam_speed_t){.spindle_mrpm = cam_speed_mrpm(cfg, cam_speed_told_q28(cfg, pace)),
                         .alpha_q40 = cam_speed_alpha_q40(cfg, pace)};
}

/// Set-point and acceleration in real numbers.
static void expect_law(const cam_speed_config_t *cfg, double r, double slope, double envelope)
{
    const cam_ratio_t ratio = {.ratio_q28 = (int32_t)lround(ldexp(r, 28)),
                               .slope_q20 = (int32_t)lround(ldexp(slope, 20))};
    const cam_speed_t found = law(cfg, ratio, (int32_t)ldexp(envelope, 30));
    const double eased = 1.0 + envelope * (r - 1.0);
    const double rise = envelope * slope;
    const double lag = ldexp(cfg->lag_turns_q24, -24);
    const double mean = ldexp(sqrt((double)cfg->mean2_q48), -24);
    const double wanted = cfg->mean_mrpm * fmin(8.0, fmax(0.0, eased + eased * rise * lag));
    const double mrpm = cfg->sense * fmin(wanted, cfg->limit_mrpm);
    TEST_ASSERT_DOUBLE_WITHIN(2.0 + 2e-6 * fabs(mrpm), mrpm, found.spindle_mrpm);
    const double alpha = ldexp(mean * mean * eased * rise, 40);
    TEST_ASSERT_DOUBLE_WITHIN(1.0 + 1e-5 * mean * mean * ldexp(1.0, 40), alpha,
                              (double)found.alpha_q40);
}

static double random_real(fixture_random_t *random, double low, double high)
{
    return low + (high - low) * ldexp(fixture_random_u32(random), -32);
}

static void test_law_is_the_inverse_of_the_speed_loop(void)
{
    fixture_random_t random = {.state = 7};
    for (int i = 0; i < 20000; i++) {
        cam_speed_config_t cfg = config.play.speed;
        cfg.sense = i % 2 == 0 ? 1 : -1;
        const double r = random_real(&random, 0.25, 4.0);
        const double slope = random_real(&random, -15.0, 15.0);
        expect_law(&cfg, r, slope, random_real(&random, 0.0, 1.0));
    }
}

static void test_extremes_saturate_without_overflow(void)
{
    cam_speed_config_t cfg = config.play.speed;
    cfg.mean_mrpm = 60000000;
    cfg.limit_mrpm = 60000000;
    cfg.lag_turns_q24 = INT32_MAX;
    cfg.mean2_q48 = INT64_C(1) << 36;
    const int32_t slopes[] = {INT32_MAX, INT32_MIN};
    for (int i = 0; i < 2; i++) {
        const cam_ratio_t ratio = {.ratio_q28 = INT32_C(1) << 30, .slope_q20 = slopes[i]};
        const cam_speed_t found = law(&cfg, ratio, INT32_C(1) << 30);
        TEST_ASSERT_EQUAL_INT32(i == 0 ? 60000000 : 0, found.spindle_mrpm);
        TEST_ASSERT_EQUAL_INT32(i == 0 ? INT32_MAX : INT32_MIN, found.alpha_q40);
    }
}

static void test_config_carries_mean_speed_lag_and_sense(void)
{
    const cam_speed_config_t *c = &config.play.speed;
    TEST_ASSERT_EQUAL_INT32(200000, c->mean_mrpm);
    TEST_ASSERT_EQUAL_INT32(1, c->sense);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 200.0 / 60.0 * 0.025, ldexp(c->lag_turns_q24, -24));
    const double mean = 200.0 / 60.0 / tick_hz;
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.0, ldexp((double)c->mean2_q48, -48) / (mean * mean));
}

static cam_angle_t angle_at(double turn, double r)
{
    const double per_tick = 200.0 / 60.0 / tick_hz * r;
    return (cam_angle_t){.pos_q32 = llround(ldexp(turn, 32)),
                         .speed_q32 = (int32_t)lround(ldexp(per_tick, 32)),
                         .is_synced = true};
}

/// In the middle of a cut at full amplitude.
static cam_play_t cutting(void)
{
    const int64_t far = INT64_C(1) << 45;
    return (cam_play_t){.state = cam_state_cutting,
                        .is_playing = true,
                        .engage_at_q32 = -far,
                        .feed_at_q32 = -far,
                        .disengage_at_q32 = far,
                        .feed_turns_q32 = 0,
                        .amplitude_q30 = INT32_C(1) << 30,
                        .scale_q30 = INT32_C(1) << 30};
}

typedef struct {
    cam_want_t want;
    cam_move_t u;
} outcome_t;

/// All tasks once, the last of them at an angle.
static outcome_t round_of(cam_play_t *play, const cam_sense_t *in, const cam_angle_t *last)
{
    outcome_t o;
    for (int back = config.play.round_ticks - 1; back >= 0; back--) {
        cam_angle_t angle = *last;
        angle.pos_q32 -= (int64_t)back * angle.speed_q32;
        cam_play_step_isr(play, &config.play, in, &angle, &o.want);
    }
    o.u = play->axis[hal_axis_u];
    return o;
}

static void test_play_gives_the_modulated_speed_and_the_acceleration_of_u(void)
{
    config.play.ratio_q16 -= config.play.lead_q16;
    config.play.lead_q16 = 0;
    const cam_sense_t in = {0};
    const double mean = 2.0 * PI * 200.0 / 60.0 / tick_hz; // rad per tick
    for (int i = 0; i < 360; i++) {
        double u[3];
        double r[3];
        const double turn = i / 360.0;
        fixture_cosine_oval(2.0 * PI * turn, 0.0, u);
        fixture_ratio(2.0 * PI * turn, 0.0, r);
        cam_play_t play = cutting();
        const cam_angle_t angle = angle_at(4.0 + turn, r[0]);
        // The law was read for the middle of the 21 ticks that use it.
        const double now = r[0];
        fixture_ratio(2.0 * PI * turn + 8.0 * mean * now, 0.0, r);
        const outcome_t o = round_of(&play, &in, &angle);
        const double lag = 200.0 / 60.0 * 0.025;
        const double mrpm = 200000.0 * (r[0] + r[0] * r[1] * 2.0 * PI * lag);
        TEST_ASSERT_INT32_WITHIN(60, (int32_t)mrpm, o.want.spindle_mrpm);
        const double acc = 1024.0 * mean * mean * (u[2] * now * now + u[1] * r[0] * r[1]);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3 * 1024.0 * mean * mean * 4e5 + 2.0, acc, o.u.acc_q10);
    }
}

static void test_speed_is_the_mean_outside_the_work(void)
{
    cam_play_t play = {.state = cam_state_ready};
    const cam_sense_t in = {0};
    const cam_angle_t angle = angle_at(3.1, 1.0);
    cam_want_t want;
    cam_play_step_isr(&play, &config.play, &in, &angle, &want);
    TEST_ASSERT_EQUAL_INT32(200000, want.spindle_mrpm);
    TEST_ASSERT_EQUAL_INT32(0, play.speed.alpha_q40);
}

static void test_modulation_rises_with_the_envelope(void)
{
    const cam_sense_t in = {0};
    cam_play_t play = cutting();
    play.engage_at_q32 = 0;
    play.feed_at_q32 = config.play.engage_q32;
    play.state = cam_state_engaging;
    int32_t last = 0;
    config.play.lead_q16 = 0;
    for (int turns = 0; turns <= 10; turns++) { // at the long axis the ratio is 1.425
        cam_play_t now = play;
        const cam_angle_t angle = angle_at(turns, 1.0);
        const int32_t above = round_of(&now, &in, &angle).want.spindle_mrpm - 200000;
        TEST_ASSERT_TRUE(above >= last);
        last = above;
    }
    TEST_ASSERT_INT32_WITHIN(3000, 85000, last); // told some ticks later
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_ratio_and_slope_are_those_of_the_function);
    RUN_TEST(test_law_is_the_inverse_of_the_speed_loop);
    RUN_TEST(test_extremes_saturate_without_overflow);
    RUN_TEST(test_config_carries_mean_speed_lag_and_sense);
    RUN_TEST(test_play_gives_the_modulated_speed_and_the_acceleration_of_u);
    RUN_TEST(test_speed_is_the_mean_outside_the_work);
    RUN_TEST(test_modulation_rises_with_the_envelope);
    return UNITY_END();
}
