// SPDX-License-Identifier: Apache-2.0
// What a wave demands of U: its samples, its steps and bends across the wrap, and the limits.
#include "cam_machine_inner.h"
#include "unity.h"

enum { tick_hz = 20000 };

static cam_config_t cfg;
static cam_wave_range_t range;
static cam_motion_limits_t fade;

void setUp(void)
{
    cfg = (cam_config_t){0};
    cfg.guard.range_nm = 500000;
    cfg.guard.u.speed_q10 = 1000 * 1024;
    cfg.guard.u.acceleration_q10 = 100 * 1024;
    range = (cam_wave_range_t){.low_nm = -20000, .high_nm = 10000, .step_nm = 500, .bend_nm = 20};
    fade = (cam_motion_limits_t){0};
}

static void expect_range(const int32_t *wave_nm, uint32_t n, int64_t low_nm, int64_t high_nm,
                         int64_t step_nm, int64_t bend_nm)
{
    const cam_wave_range_t r = cam_wave_range(wave_nm, n);
    TEST_ASSERT_EQUAL_INT64(low_nm, r.low_nm);
    TEST_ASSERT_EQUAL_INT64(high_nm, r.high_nm);
    TEST_ASSERT_EQUAL_INT64(step_nm, r.step_nm);
    TEST_ASSERT_EQUAL_INT64(bend_nm, r.bend_nm);
}

/// The first sample follows the last; 0 is in the range, since the wave fades to it.
static void test_range_is_that_of_the_samples_and_of_their_differences(void)
{
    static const int32_t above[] = {10, 12, 20, 13};
    static const int32_t below[] = {-10, -12, -20, -13};
    static const int32_t wrap[] = {0, 100, 200, 300};
    static const int32_t far[] = {INT32_MIN, INT32_MAX};
    expect_range(above, 4, 0, 20, 8, 15);
    expect_range(below, 4, -20, 0, 8, 15);
    expect_range(wrap, 4, 0, 300, 300, 400);
    expect_range(far, 2, INT32_MIN, INT32_MAX, UINT32_MAX, 2 * (int64_t)UINT32_MAX);
}

/// A triangle of speed: the gain rises in so many ticks, up to a quarter less where they are many.
static void test_fade_takes_its_ticks(void)
{
    static const uint32_t ticks[] = {cam_wave_least, 100, 1000, 10000, cam_wave_longest_fade};
    for (uint32_t i = 0; i < sizeof ticks / sizeof ticks[0]; i++) {
        const cam_motion_limits_t limits = cam_wave_fade(ticks[i]);
        const uint32_t n = cam_wave_fall_ticks(&limits);
        TEST_ASSERT_TRUE(n <= ticks[i] + 1u && n >= ticks[i] * 3u / 4u - 1u);
        TEST_ASSERT_TRUE(n + 3u >= ticks[i] || ticks[i] > 1000u);
    }
    const cam_motion_limits_t to_the_end = cam_wave_fade(2049); // to 2^-30 it takes a tick more
    TEST_ASSERT_EQUAL_UINT32(2047, cam_wave_fall_ticks(&to_the_end));
}

/// The wave is one of positions, or of force where a force has a limit.
static void expect(cam_err_t err, int32_t value, int32_t place_nm)
{
    const bool is_force = cfg.force.servo.limit_q6 > 0;
    const cam_verdict_t v = cam_wave_judge(&range, &fade, is_force, place_nm, &cfg, tick_hz);
    TEST_ASSERT_EQUAL_INT(err, v.err);
    TEST_ASSERT_EQUAL_INT32(value, v.value);
}

/// Of the place that is farthest from 0.
static void test_stroke_is_that_of_both_sides(void)
{
    expect(cam_ok, 0, -480000);
    expect(cam_err_wave_stroke, -500001, -480001);
    expect(cam_ok, 0, 490000);
    expect(cam_err_wave_stroke, 500001, 490001);
}

/// Of either sense, whatever it would be as a motion; then the position is that of the wave.
static void test_force_is_within_its_limit(void)
{
    cfg.force.servo.limit_q6 = 20000 * 64;
    range.step_nm = range.bend_nm = 40000;
    expect(cam_ok, 0, -500000);
    expect(cam_err_wave_stroke, 500001, 500001);
    range.low_nm = -20001;
    expect(cam_err_wave_force, 20001, 500001);
    range.low_nm = 0;
    range.high_nm = 20001;
    expect(cam_err_wave_force, 20001, 0);
    range.low_nm = INT32_MIN;
    expect(cam_err_wave_force, INT32_MAX, 0);
}

/// Speed: the steps of the samples, and what the gain adds by its own speed to the largest of them.
/// Acceleration: the bends of the samples, twice the step times the speed of the gain, and the wave
/// times its acceleration. The rounding up of a share of nothing is in both.
static void test_speed_and_acceleration_are_those_of_the_wave_and_its_fade(void)
{
    enum { one = 1 << 30 };
    static const struct {
        int64_t high_nm, step_nm, bend_nm;
        int32_t fade_speed_q10, fade_acceleration_q10;
        cam_err_t err;
        int32_t value;
    } cases[] = {
        {10000, 999, 20, 0, 0, cam_ok, 0},
        {10000, 1000, 20, 0, 0, cam_err_wave_speed, 20001},
        {10000, 500, 20, one / 40, 0, cam_ok, 0}, // of 20000 nm
        {10000, 501, 20, one / 40, 0, cam_err_wave_speed, 20020},
        {20100, 500, 20, one / 40, 0, cam_err_wave_speed, 20050},
        {10000, 500, 99, 0, 0, cam_ok, 0},
        {10000, 500, 100, 0, 0, cam_err_wave_acceleration, 40000},        // nm / tick^2: 40 m/s2
        {10000, 500, 20, 0, one / 250, cam_err_wave_acceleration, 40000}, // 80 nm of 20000
        {10000, 500, 19, 0, one / 250, cam_ok, 0},
        {10000, 500, 20, one / 50, 0, cam_ok, 0}, // 400 nm / tick of the wave, 20 of 1000
        {10000, 500, 80, one / 50, 0, cam_err_wave_acceleration, 40000},
        {10000, 500, 79, one / 50, 0, cam_ok, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        range.high_nm = cases[i].high_nm;
        range.step_nm = cases[i].step_nm;
        range.bend_nm = cases[i].bend_nm;
        fade.speed_q10 = cases[i].fade_speed_q10;
        fade.acceleration_q10 = cases[i].fade_acceleration_q10;
        expect(cases[i].err, cases[i].value, 0);
    }
}
