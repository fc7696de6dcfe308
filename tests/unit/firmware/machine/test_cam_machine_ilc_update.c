// SPDX-License-Identifier: Apache-2.0
// What the parameters ask of learning, as turns that the test makes show it: gains, probe, ripple.
#include "cam_machine.h"
#include "rig_bench.h"
#include <math.h>

#define TURN 6.283185307179586

enum { n_ticks = 400, set_nm = 100000, error_nm = 1000 };

static uint32_t turn; ///< number of the last one

/// Start anew with a drive of which nothing is known.
static void begin(void)
{
    setUp();
    turn = 0;
    hal_host.slow.measures_u = true;
    set(cam_param_k1_ns, 0);
    set(cam_param_k2_us2, 0);
    set(cam_param_learn_harmonics, 4);
}

/// Close a turn in which U moves by a cosine and is behind by a sine, and let the slow side treat
/// it.
static void play(cam_state_t state)
{
    cam_turn_bins_t *g = &rig.machine.core->bins;
    turn++;
    const uint32_t bank = turn & 1u;
    for (uint32_t i = 0; i < n_ticks; i++) {
        const double at = (i + 0.5) / n_ticks;
        const uint32_t b = i * cam_turn_bins_n / n_ticks;
        cam_turn_bin_t *bin = &g->bin[bank * cam_turn_bins_n + b];
        bin->n++;
        bin->u_nm += (int32_t)lround(set_nm * cos(TURN * at));
        bin->error_q6 -= (int32_t)lround(64.0 * error_nm * sin(TURN * at));
        bin->angle_q24 += (int32_t)lround((at - (double)b / cam_turn_bins_n) * 16777216.0);
    }
    g->closed[bank] = (cam_turn_t){.turn = turn,
                                   .is_steady = true,
                                   .is_level = true,
                                   .state = state,
                                   .speed_q32 = 10737418,
                                   .scale_q30 = 1 << 30};
    g->closed_turn[bank] = turn | 1u << 24;
    g->at_q8 = (turn + 1u) << 8 | 10u;
    rig.machine.ilc.blending = 0;
    rig.machine.ilc.good_from = 0;
    for (int i = 0; i < 40; i++) {
        cam_machine_ilc_poll(&rig.machine, state, !cam_machine_status(&rig.machine).is_u_at_rest);
    }
}

static void play_turns(int n, cam_state_t state)
{
    for (int i = 0; i < n; i++) {
        play(state);
    }
}

/// An error of a hundredth behind by a quarter turn is k1 w = 1 / 100: of that a step of the
/// rehearsal takes the share that is set.
static void test_gain_of_the_rehearsal_is_the_one_that_is_set(void)
{
    static const int32_t gains_ppm[] = {150000, 400000, 600000};
    for (int i = 0; i < 3; i++) {
        begin();
        set(cam_param_learn_gain_ppm, gains_ppm[i]);
        play_turns(2, cam_state_rehearsing);
        const double due = gains_ppm[i] * 1e-6 * 0.01 * n_ticks / TURN;
        TEST_ASSERT_DOUBLE_WITHIN(0.02 * due, due, rig.machine.ilc.k1_q16 / 65536.0);
    }
}

/// In the cut it is its own; of none nothing is learned there.
static void test_gain_of_the_cut_is_the_one_that_is_set(void)
{
    static const int32_t gains_ppm[] = {0, 100000, 200000};
    for (int i = 0; i < 3; i++) {
        begin();
        set(cam_param_learn_cut_gain_ppm, gains_ppm[i]);
        play_turns(2, cam_state_cutting);
        rig.machine.ilc.n_steps = 20; // the larger gain of the first turns is over
        const int32_t before_q16 = rig.machine.ilc.k1_q16;
        play(cam_state_cutting);
        const double due = gains_ppm[i] * 1e-6 * 0.01 * n_ticks / TURN;
        TEST_ASSERT_DOUBLE_WITHIN(0.02 * due + 1e-4, due,
                                  (rig.machine.ilc.k1_q16 - before_q16) / 65536.0);
    }
}

/// The first probe is half of the one that is set, at least three steps of the scale, at each of 4
/// harmonics and the mean.
static void test_probe_is_the_one_that_is_set_or_three_steps_of_the_scale(void)
{
    static const int32_t cases[][3] = {{2000, 0, 2000}, {2000, 600, 2000}, {2000, 700, 2100}};
    for (int i = 0; i < 3; i++) {
        begin();
        set(cam_param_probe_nm, cases[i][0]);
        set(cam_param_u_scale_nm, cases[i][1]);
        play_turns(8, cam_state_rehearsing);
        TEST_ASSERT_EQUAL_UINT8(cam_ilc_probing, rig.machine.ilc.phase);
        TEST_ASSERT_UINT32_WITHIN(8, 5u * 32u * (uint32_t)cases[i][2],
                                  cam_harmonic_correction_sum_q6(&rig.machine.ilc.correction));
    }
}

/// A mean of the ripple has the turns that are set, but two at least; of a table that modulates the
/// speed, or without one, there is none.
static void test_turns_of_the_ripple_are_those_that_are_set(void)
{
    static const uint32_t cases[][2] = {{0, 0}, {1, 2}, {2, 2}, {3, 3}};
    for (int i = 0; i < 4; i++) {
        begin();
        set(cam_param_ripple_turns, (int32_t)cases[i][0]);
        play_turns(6, cam_state_ready);
        TEST_ASSERT_EQUAL_UINT32(cases[i][1], rig.machine.ilc.ripple.n_mean);
    }
    begin();
    set(cam_param_ripple_turns, 2);
    rig.machine.table.speed = rig.machine.table.u;
    play_turns(6, cam_state_ready);
    TEST_ASSERT_EQUAL_UINT32(0, rig.machine.ilc.ripple.n_mean);
    begin();
    set(cam_param_ripple_turns, 2);
    rig.machine.has_table = false;
    play_turns(6, cam_state_ready);
    TEST_ASSERT_EQUAL_UINT32(0, rig.machine.ilc.ripple.n_mean);
}
