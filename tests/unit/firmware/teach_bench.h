// SPDX-License-Identifier: Apache-2.0
/// teach_bench: turns for cam_teach that the test makes, in which U moves by a cosine and has an
/// error in harmonic 1; setUp() of the tests that include it.
#ifndef TEACH_BENCH_H
#define TEACH_BENCH_H

#include "cam_lesson.h"
#include "cam_teach.h"
#include "unity.h"
#include <math.h>

#define TURN 6.283185307179586

enum { usual_ticks = 400, usual_speed_q32 = 10737418, usual_set_nm = 100000 };

static cam_teach_t t;
static cam_teach_setup_t s;
static cam_gather_t g;
static cam_turn_t how;   ///< the turns to come; turn is the number of the last one
static uint32_t n_ticks; ///< of each turn
static double error_nm;  ///< amplitude of the error in harmonic 1
static int n_polls;      ///< of the slow side, for each turn
static uint8_t walked;   ///< what the last turn has changed

void setUp(void)
{
    cam_teach_init(&t);
    g = (cam_gather_t){0};
    s = (cam_teach_setup_t){.reason = cam_teach_all,
                            .n_harmonics = 4,
                            .gain_q16 = 32768,
                            .cut_gain_q16 = 8192,
                            .probe_q6 = 64 * 2000,
                            .most_q6 = 64 * 30000,
                            .k1_q16 = 65536,
                            .k1_most_q16 = 20 * 65536,
                            .k2_most_q16 = 40 * 65536};
    how = (cam_turn_t){.is_steady = true,
                       .state = cam_state_rehearsing,
                       .speed_q32 = usual_speed_q32,
                       .scale_q30 = 1 << 30};
    n_ticks = usual_ticks;
    error_nm = 1000.0;
    n_polls = 40;
}

void tearDown(void) {}

/// Close a turn in which U moves by a cosine and is behind by a sine, as by a wrong k1, and let the
/// slow side treat it.
static void play(void)
{
    how.turn++;
    const uint32_t bank = how.turn & 1u;
    for (uint32_t i = 0; i < n_ticks; i++) {
        const double at = TURN * (i + 0.5) / n_ticks;
        cam_gather_bin_t *bin = &g.bin[bank * cam_learn_bins + i * cam_learn_bins / n_ticks];
        bin->n++;
        bin->u_nm += (int32_t)lround(usual_set_nm * cos(at));
        bin->error_q6 += (int32_t)lround(-64.0 * error_nm * sin(at));
    }
    g.closed[bank] = how;
    g.closed_turn[bank] = how.turn | 1u << 24;
    g.at_q8 = (how.turn + 1u) << 8 | 10u;
    t.walking = 0; // what the last turn has changed is in force
    for (int i = 0; i < n_polls; i++) {
        cam_teach_poll(&t, &s, how.state, &g);
    }
    TEST_ASSERT_NULL(t.bin);
    walked = t.walking;
}

static void play_turns(int n)
{
    for (int i = 0; i < n; i++) {
        play();
    }
}

#endif
