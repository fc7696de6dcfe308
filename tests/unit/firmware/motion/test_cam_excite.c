// SPDX-License-Identifier: Apache-2.0
// The wave as it is played: its gain, its end, and its bounds, those that it was judged by.
#include "cam_motion.h"
#include "cam_machine_inner.h"
#include "fixture_random.h"
#include "unity.h"
#include <stdlib.h> // abs

enum { tick_hz = 20000, longest = 64 };

static int32_t wave_nm[longest];

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

static void expect_within(double most_step_q6, double most_bend_q6, const int32_t *out,
                          uint32_t n_ticks)
{
    int32_t last_q6 = out[0];
    int32_t last_step_q6 = 0;
    for (uint32_t i = 1; i < n_ticks + 2u; i++) {
        const int32_t now_q6 = i < n_ticks ? out[i] : 0;
        const int32_t step_q6 = now_q6 - last_q6;
        TEST_ASSERT_TRUE(abs(now_q6) <= 10000 * 64);
        TEST_ASSERT_TRUE(abs(step_q6) <= most_step_q6 + 2.0);
        TEST_ASSERT_TRUE(abs(step_q6 - last_step_q6) <= most_bend_q6 + 4.0);
        last_q6 = now_q6;
        last_step_q6 = step_q6;
    }
}

/// A gain that is asked to fall at any tick makes no larger step or bend than those for which the
/// judge refuses the wave.
static void test_every_end_stays_within_the_bounds(void)
{
    enum { n = 40, n_out = 600 };
    static int32_t out[n_out];
    static cam_config_t cfg;
    fixture_random_t random = {7};
    for (int i = 0; i < n; i++) {
        wave_nm[i] = (int32_t)fixture_random_range(&random, -10000, 10000);
    }
    const cam_motion_limits_t fade = cam_wave_fade(60);
    const cam_wave_range_t range = cam_wave_range(wave_nm, n);
    cfg.guard.range_nm = 10000;
    const cam_verdict_t fast = cam_wave_judge(&range, &fade, false, 0, &cfg, tick_hz);
    TEST_ASSERT_EQUAL_INT(cam_err_wave_speed, fast.err);
    cfg.guard.u.speed_q10 = INT32_MAX;
    const cam_verdict_t steep = cam_wave_judge(&range, &fade, false, 0, &cfg, tick_hz);
    TEST_ASSERT_EQUAL_INT(cam_err_wave_acceleration, steep.err);
    const double step_q6 = fast.value * 64e3 / tick_hz;
    const double bend_q6 = (steep.value + 1) * 64e6 / tick_hz / tick_hz;
    const cam_excite_config_t c = {.wave = wave_nm, .n = n, .n_play = 200, .fade = fade};
    for (uint32_t end = 0; end < 220u; end += 3u) {
        expect_within(step_q6, bend_q6, out, play(&c, end, out, n_out));
    }
}
