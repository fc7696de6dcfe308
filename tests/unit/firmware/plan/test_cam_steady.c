// SPDX-License-Identifier: Apache-2.0
// Waiting for a steady spindle: a spindle of known speed, timed with floating point.
#include "cam_plan_inner.h" // cam_steady_t, cam_steady_isr
#include "unity.h"
#include <math.h> // sin

enum { plan_ticks = 8, tick_hz = 20000 };

static cam_play_config_t cfg;
static cam_steady_t s;

void setUp(void)
{
    cfg = (cam_play_config_t){.plan_ticks = plan_ticks, .agreeing_q16 = 128, .steady_turns = 1};
    s = (cam_steady_t){0};
}

/// A spindle at per_s turns per second that changes by a share per turn, with a ripple per turn.
typedef struct {
    double per_s, change, ripple;
} spindle_t;

/// @return turns until the cut may begin with the axes there all the time, at most 100
static double turns_before(spindle_t spindle, double from)
{
    const double begin = from;
    double turn = from;
    double speed = spindle.per_s;
    while (!cam_steady_isr(&s, &cfg, cam_state_engaging, (int64_t)(turn * 4294967296.0), true) &&
           turn < begin + 100.0) {
        for (int i = 0; i < plan_ticks; i++) {
            const double by = speed * (1.0 + spindle.ripple * sin(6.283185307 * turn)) / tick_hz;
            turn += by;
            speed *= 1.0 + spindle.change * by;
        }
    }
    return turn - begin;
}

static void test_steady_spindle_waits_two_turns_at_any_speed(void)
{
    for (double per_s = 0.1; per_s < 120.0; per_s *= 1.7) {
        setUp();
        const double plan = per_s * plan_ticks / tick_hz;
        TEST_ASSERT_DOUBLE_WITHIN(plan + 1e-6, 2.0 + plan,
                                  turns_before((spindle_t){per_s, 0, 0}, 0.3));
    }
}

/// The limit is 1/512 per turn, in both directions; a ripple repeats with the turn.
static void test_changing_spindle_waits(void)
{
    static const struct {
        const char *name;
        spindle_t spindle;
        double from;
        uint32_t steady_turns;
        double least, most;
    } rows[] = {
        {"ripple", {50, 0, 0.01}, -7.2, 1, 2.0, 2.1},
        {"slightly faster", {20, 1.0 / 600, 0}, 0, 1, 2.0, 2.1},
        {"slightly slower", {20, -1.0 / 600, 0}, 0, 1, 2.0, 2.1},
        {"faster", {20, 1.0 / 450, 0}, 0, 1, 99, 101},
        {"slower", {20, -1.0 / 450, 0}, 0, 1, 99, 101},
        {"more turns wanted", {50, 0, 0}, 0, 11, 11.9, 12.3},
        {"runs up", {50, 0.03, 0}, 0, 1, 50, 101},
    };
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        setUp();
        cfg.steady_turns = rows[i].steady_turns;
        const double turns = turns_before(rows[i].spindle, rows[i].from);
        TEST_ASSERT_TRUE_MESSAGE(turns >= rows[i].least && turns <= rows[i].most, rows[i].name);
        if (i == 3u) {
            TEST_ASSERT_EQUAL_UINT32(0, s.n_agreeing);
            TEST_ASSERT_UINT32_WITHIN(3, 98, s.n_turns);
        }
    }
}

/// The approach counts: whoever comes late does not wait, and only the wait is timed.
static void test_turns_count_while_the_axes_approach(void)
{
    int64_t pos_q32 = 0;
    for (int i = 0; i < 150; i++) { // of 2 % of a turn
        TEST_ASSERT_FALSE(cam_steady_isr(&s, &cfg, cam_state_rehearsing, pos_q32, false));
        pos_q32 += 85899346;
    }
    TEST_ASSERT_EQUAL_UINT32(0, s.waited_ticks);
    TEST_ASSERT_TRUE(cam_steady_isr(&s, &cfg, cam_state_rehearsing, pos_q32, true));
    TEST_ASSERT_FALSE(cam_steady_isr(&s, &cfg, cam_state_engaging, pos_q32, true)); // from new on
    TEST_ASSERT_EQUAL_UINT32(plan_ticks, s.waited_ticks);
    TEST_ASSERT_FALSE(cam_steady_isr(&s, &cfg, cam_state_ready, pos_q32, true));
    TEST_ASSERT_EQUAL_UINT32(0, s.waited_ticks + s.n_turns);
}

/// A spindle that turns backwards or stands completes no turn.
static void test_no_turn_no_cut(void)
{
    for (int i = 0; i < 1000; i++) {
        TEST_ASSERT_FALSE(cam_steady_isr(&s, &cfg, cam_state_engaging, -i * 85899346LL, true));
    }
    TEST_ASSERT_EQUAL_UINT32(0, s.n_turns);
}
