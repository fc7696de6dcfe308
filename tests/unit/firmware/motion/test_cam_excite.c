// SPDX-License-Identifier: Apache-2.0
// The wave itself: its gain, its bounds, its judgement.
#include "cam_excite.h"
#include "cam_wave.h"
#include "fixture_random.h"
#include "unity.h"
#include <stdlib.h> // abs

enum { tick_hz = 20000, longest = 64 };

static int32_t wave_nm[longest];
static cam_config_t cfg;

void setUp(void)
{
    for (int i = 0; i < longest; i++) {
        wave_nm[i] = 0;
    }
    cfg = (cam_config_t){0};
    cfg.guard.range_nm = 600000;
    cfg.guard.u = (cam_motion_limits_t){.speed_q10 = 20480000, .acceleration_q10 = 640000};
}

/// Play until it is over, and end it before tick `end`. @return ticks; every offset in *out
static uint32_t play(const cam_excite_config_t *c, uint32_t end, int32_t *out, uint32_t n_out)
{
    cam_excite_t e = {.at = c->first, .n_left = c->n_play};
    bool is_over = false;
    uint32_t n = 0;
    for (; n < n_out && !is_over; n++) {
        if (n == end) {
            e.n_left = 0;
        }
        is_over = cam_excite_step_isr(&e, c, &out[n]);
    }
    TEST_ASSERT_TRUE(is_over);
    return n;
}

static void test_gain_rises_and_falls_in_the_ticks_that_are_asked(void)
{
    static const uint32_t fades[] = {16, 17, 100, 2000, 65535};
    for (uint32_t i = 0; i < 5u; i++) {
        const cam_motion_limits_t fade = cam_wave_fade(fades[i]);
        const uint32_t n = cam_wave_fall_ticks(&fade);
        TEST_ASSERT_UINT32_WITHIN(fades[i] / 4u + 4u, fades[i], n);
    }
}

static void test_periods_in_full_are_the_samples(void)
{
    enum { n = 7, n_periods = 3, n_out = 200 };
    static int32_t out[n_out];
    for (int i = 0; i < n; i++) {
        wave_nm[i] = 1000 * i - 2500;
    }
    const cam_motion_limits_t fade = cam_wave_fade(20);
    const uint32_t n_fall = cam_wave_fall_ticks(&fade);
    const cam_excite_config_t c = {.wave = wave_nm,
                                   .n = n,
                                   .first = (n - n_fall % n) % n,
                                   .n_play = n_fall + n * n_periods,
                                   .fade = fade};
    const uint32_t n_ticks = play(&c, UINT32_MAX, out, n_out);
    TEST_ASSERT_EQUAL_UINT32(2u * n_fall + n * n_periods + 1u, n_ticks);
    for (uint32_t i = 0; i < n * n_periods; i++) {
        TEST_ASSERT_EQUAL_INT32(wave_nm[i % n] * 64, out[n_fall + i]);
    }
    TEST_ASSERT_EQUAL_INT32(0, out[n_ticks - 1u]);
}

/// After the last tick, or an earlier end, nothing of a force follows.
static void test_force_ends_without_a_fall(void)
{
    enum { n = 7, n_out = 200 };
    static int32_t out[n_out];
    for (int i = 0; i < n; i++) {
        wave_nm[i] = 1000 * i + 2500;
    }
    const cam_excite_config_t c = {
        .wave = wave_nm, .n = n, .n_play = 100, .fade = cam_wave_fade(20), .is_force = true};
    static const uint32_t ends[] = {UINT32_MAX, 60, 0};
    for (uint32_t i = 0; i < 3u; i++) {
        const uint32_t n_ticks = play(&c, ends[i], out, n_out);
        const uint32_t last = ends[i] < 100u ? ends[i] : 100u;
        TEST_ASSERT_EQUAL_UINT32(last + 1u, n_ticks);
        TEST_ASSERT_EQUAL_INT32(0, out[last]);
        TEST_ASSERT_TRUE(last == 0u || out[last - 1u] == wave_nm[(last - 1u) % n] * 64);
    }
}

/// Bounds of a set-point.
typedef struct {
    int64_t most_nm;
    double step_nm, bend_nm;
} bounds_t;

/// The bounds that a wave is judged by, from its own formula in floating point.
static bounds_t bounds_of(const cam_wave_range_t *range, const cam_motion_limits_t *fade)
{
    const int64_t most_nm = -range->low_nm > range->high_nm ? -range->low_nm : range->high_nm;
    const double g1 = fade->speed_q10 / 1073741824.0;
    const double g2 = fade->acceleration_q10 / 1073741824.0;
    const double step_nm = (double)range->step_nm;
    return (bounds_t){
        .most_nm = most_nm,
        .step_nm = step_nm + g1 * (double)most_nm + 0.1,
        .bend_nm = (double)range->bend_nm + 2.0 * g1 * step_nm + g2 * (double)most_nm + 0.1,
    };
}

static void expect_within(const bounds_t *b, const int32_t *out, uint32_t n_ticks)
{
    int32_t last_q6 = out[0];
    int32_t last_step_q6 = 0;
    for (uint32_t i = 1; i < n_ticks + 2u; i++) {
        const int32_t now_q6 = i < n_ticks ? out[i] : 0;
        const int32_t step_q6 = now_q6 - last_q6;
        TEST_ASSERT_TRUE(abs(now_q6) <= b->most_nm * 64);
        TEST_ASSERT_TRUE(abs(step_q6) <= b->step_nm * 64.0 + 2.0);
        TEST_ASSERT_TRUE(abs(step_q6 - last_step_q6) <= b->bend_nm * 64.0 + 4.0);
        last_q6 = now_q6;
        last_step_q6 = step_q6;
    }
}

/// A gain that is asked to fall at any tick takes the set-point nowhere beyond the bounds that the
/// wave was judged by.
static void test_every_end_stays_within_the_bounds(void)
{
    enum { n = 40, n_out = 600 };
    static int32_t out[n_out];
    fixture_random_t random = {7};
    for (int i = 0; i < n; i++) {
        wave_nm[i] = (int32_t)fixture_random_range(&random, -10000, 10000);
    }
    const cam_motion_limits_t fade = cam_wave_fade(60);
    const cam_wave_range_t range = cam_wave_range(wave_nm, n);
    const cam_excite_config_t c = {.wave = wave_nm, .n = n, .n_play = 200, .fade = fade};
    const bounds_t bounds = bounds_of(&range, &fade);
    for (uint32_t end = 0; end < 220u; end += 3u) {
        expect_within(&bounds, out, play(&c, end, out, n_out));
    }
}

static cam_verdict_t judge(uint32_t n, int32_t place_nm, uint32_t fade_ticks)
{
    const cam_wave_range_t range = cam_wave_range(wave_nm, n);
    const cam_motion_limits_t fade = cam_wave_fade(fade_ticks);
    return cam_wave_judge(&range, &fade, place_nm, &cfg, tick_hz);
}

static void test_range_knows_the_wrap(void)
{
    wave_nm[19] = 5000;
    wave_nm[18] = 4000;
    const cam_wave_range_t range = cam_wave_range(wave_nm, 20);
    TEST_ASSERT_EQUAL_INT64(0, range.low_nm);
    TEST_ASSERT_EQUAL_INT64(5000, range.high_nm);
    TEST_ASSERT_EQUAL_INT64(5000, range.step_nm);
    TEST_ASSERT_EQUAL_INT64(6000, range.bend_nm); // +1000, then -5000
    wave_nm[19] = INT32_MIN;
    wave_nm[0] = INT32_MAX;
    TEST_ASSERT_EQUAL_INT64(INT64_C(4294967295), cam_wave_range(wave_nm, 20).step_nm);
}

static void test_limits_are_those_of_u_and_reported_in_their_units(void)
{
    wave_nm[3] = 100;
    TEST_ASSERT_EQUAL_INT(cam_ok, judge(32, 599900, 2000).err);
    cam_verdict_t v = judge(32, 599901, 2000);
    TEST_ASSERT_EQUAL_INT(cam_err_wave_stroke, v.err);
    TEST_ASSERT_EQUAL_INT32(600001, v.value);
    wave_nm[3] = -100;
    v = judge(32, -599901, 2000);
    TEST_ASSERT_EQUAL_INT(cam_err_wave_stroke, v.err);
    TEST_ASSERT_EQUAL_INT32(-600001, v.value);
    wave_nm[3] = 400; // bends by 800 nm per tick^2: 320 m/s2, 250 are allowed
    v = judge(32, 0, 2000);
    TEST_ASSERT_EQUAL_INT(cam_err_wave_acceleration, v.err);
    TEST_ASSERT_INT32_WITHIN(1000, 320000, v.value);
    for (int i = 0; i < 32; i++) { // 30 um per tick: 600 mm/s, 400 are allowed
        wave_nm[i] = 30000 * (i < 16 ? i : 32 - i);
    }
    v = judge(32, -300000, 60000);
    TEST_ASSERT_EQUAL_INT(cam_err_wave_speed, v.err);
    TEST_ASSERT_INT32_WITHIN(2000, 600000, v.value);
}

static void test_any_samples_are_judged_without_overflow(void)
{
    fixture_random_t random = {1};
    for (int k = 0; k < 200; k++) {
        for (int i = 0; i < longest; i++) {
            wave_nm[i] = (int32_t)fixture_random_u32(&random);
        }
        TEST_ASSERT_EQUAL_INT(cam_err_wave_stroke, judge(longest, 0, 16).err);
    }
}
