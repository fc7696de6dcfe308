// SPDX-License-Identifier: Apache-2.0
// Learning turn by turn, of turns that the test makes: which count, what the guard does, how the
// phases follow each other.
#include "cam_learning_inner.h" // cam_harmonic_correction_sum_q6
#include "ilc_bench.h"

/// U does not answer, so a third, larger probe follows the usual two.
static void test_a_rehearsal_is_a_turn_to_settle_five_of_the_drive_and_four_of_the_probe(void)
{
    static const cam_ilc_phase_t after[] = {
        cam_ilc_settling, cam_ilc_drive,   cam_ilc_drive,   cam_ilc_drive,
        cam_ilc_drive,    cam_ilc_drive,   cam_ilc_probing, cam_ilc_probing,
        cam_ilc_probing,  cam_ilc_probing, cam_ilc_shape,   cam_ilc_shape,
    };
    static const uint32_t played_q6[] = {0, 0,         0,         0,         0, 0,
                                         0, 64 * 1000, 64 * 2000, 64 * 5000, 0, 0};
    for (uint32_t i = 0; i < sizeof after / sizeof after[0]; i++) {
        play();
        TEST_ASSERT_EQUAL_UINT8(after[i], t.phase);
        if (t.phase != cam_ilc_shape) { // at each of 4 harmonics and the mean
            TEST_ASSERT_UINT32_WITHIN(9, 5u * played_q6[i],
                                      cam_harmonic_correction_sum_q6(&t.correction));
        }
        TEST_ASSERT_EQUAL(after[i] == cam_ilc_shape, t.correction.is_probed);
    }
    TEST_ASSERT_EQUAL_UINT32(11, t.n_turns);
    TEST_ASSERT_EQUAL_INT32(usual_speed_q32, t.speed_q32);
}

/// A probe that hardly grows would show nothing: 5 um are the end, after a third of that at most.
static void test_probes_grow_to_five_micrometres(void)
{
    static const uint32_t sizes_nm[][4] = {
        {1000, 2500, 5000, 0}, {100, 250, 625, 1562}, {3000, 5000, 0}, {4000, 0}};
    for (uint32_t i = 0; i < sizeof sizes_nm / sizeof sizes_nm[0]; i++) {
        setUp();
        s.probe_q6 = 64 * (int32_t)sizes_nm[i][0];
        play_turns(9);
        for (uint32_t j = 1; j < 4u && sizes_nm[i][j - 1u] > 0u; j++) {
            play();
            const bool is_over = sizes_nm[i][j] == 0u;
            TEST_ASSERT_EQUAL_UINT8(is_over ? cam_ilc_shape : cam_ilc_probing, t.phase);
            TEST_ASSERT_UINT32_WITHIN(is_over ? UINT32_MAX : 200u, 64u * 5u * sizes_nm[i][j],
                                      cam_harmonic_correction_sum_q6(&t.correction));
        }
    }
}

/// Of a shaft with lobes only the drive's constants are learned, however long it is rehearsed.
static void test_lobes_are_not_probed(void)
{
    s.reason = cam_ilc_lobes;
    play_turns(20);
    TEST_ASSERT_EQUAL_UINT8(cam_ilc_drive, t.phase);
    TEST_ASSERT_FALSE(t.correction.is_probed);
    TEST_ASSERT_NOT_EQUAL(0, t.drive.k1_q16);
}

static void test_error_is_reported_as_rms(void)
{
    settle();
    TEST_ASSERT_UINT32_WITHIN(2, 707, t.begun_nm);
    TEST_ASSERT_EQUAL_UINT32(t.begun_nm, t.error_nm);
    error_nm = 500.0;
    play();
    TEST_ASSERT_UINT32_WITHIN(2, 354, t.error_nm);
    TEST_ASSERT_UINT32_WITHIN(2, 707, t.begun_nm);
    TEST_ASSERT_UINT32_WITHIN(1000, 64 * usual_set_nm, t.largest);
    set_nm = usual_set_nm / 2.0;
    play();
    TEST_ASSERT_UINT32_WITHIN(1000, 32 * usual_set_nm, t.largest);
}

/// An error of a hundredth, behind by a quarter turn, is k1 w = 1 / 100; of it a step removes the
/// gain's share, and half as much with each strike of the guard. After four of them none.
static void test_a_step_is_the_share_of_the_gain_and_halves_with_each_strike(void)
{
    settle();
    const double w = TURN / usual_ticks;
    const int32_t first_q16 = t.drive.k1_q16;
    TEST_ASSERT_INT32_WITHIN(first_q16 / 20, (int32_t)lround(0.5 * 0.01 / w * 65536.0), first_q16);
    for (uint8_t strikes = 0; strikes <= 4u; strikes++) {
        t.n_halved = strikes;
        t.drive.k1_q16 = t.drive.k2_q16 = 0;
        t.phase = cam_ilc_drive;
        t.n_steps = 0;
        t.best_square = UINT64_MAX;
        play();
        const int32_t due_q16 = strikes < 4u ? first_q16 >> strikes : 0;
        TEST_ASSERT_INT32_WITHIN(2, due_q16, t.drive.k1_q16);
        TEST_ASSERT_EQUAL_HEX8(strikes < 4u ? cam_ilc_blend_drive : 0,
                               walked & cam_ilc_blend_drive);
        TEST_ASSERT_EQUAL_UINT8(strikes < 4u ? cam_ilc_all : cam_ilc_diverged, t.hindrance);
    }
}

/// Where in the turn U moves makes no difference.
static void test_a_step_does_not_depend_on_the_orientation(void)
{
    settle();
    const int32_t first_q16 = t.drive.k1_q16;
    for (int eighth = 1; eighth < 8; eighth++) {
        setUp();
        phase_turn = eighth / 8.0;
        play_turns(2);
        TEST_ASSERT_INT32_WITHIN(first_q16 / 1000, first_q16, t.drive.k1_q16);
        TEST_ASSERT_INT32_WITHIN(1000, 64 * usual_set_nm, t.largest);
    }
}

/// Beside the shape layer 1 takes half of its gain, in the cut as well, where it is that of the
/// first turns, and then the smaller one of the cut.
static void test_the_two_layers_share_their_gain(void)
{
    static const struct {
        cam_state_t state;
        cam_ilc_phase_t phase;
        bool is_probed;
        uint8_t n_steps;
        int32_t share; ///< of the gain of the rehearsal, in 1 / 8
    } cases[] = {
        {cam_state_rehearsing, cam_ilc_drive, false, 0, 8},
        {cam_state_rehearsing, cam_ilc_shape, true, 0, 4},
        {cam_state_rehearsing, cam_ilc_shape, true, 99, 4},
        {cam_state_cutting, cam_ilc_cutting, false, 0, 8},
        {cam_state_cutting, cam_ilc_cutting, false, 15, 8},
        {cam_state_cutting, cam_ilc_cutting, false, 16, 2},
        {cam_state_cutting, cam_ilc_cutting, true, 0, 4},
        {cam_state_cutting, cam_ilc_cutting, true, 16, 1},
    };
    settle();
    const int32_t first_q16 = t.drive.k1_q16;
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        settle();
        how.state = cases[i].state;
        play();
        t.phase = (uint8_t)cases[i].phase;
        t.n_steps = cases[i].n_steps;
        t.correction.is_probed = cases[i].is_probed;
        t.correction.masked = UINT32_MAX;
        t.drive.k1_q16 = t.drive.k2_q16 = 0;
        t.best_square = UINT64_MAX;
        play();
        TEST_ASSERT_INT32_WITHIN(2, first_q16 * cases[i].share / 8, t.drive.k1_q16);
    }
    s.cut_gain_q16 = 0; // no learning there, nor by the larger gain
    t.n_steps = 0;
    t.drive.k1_q16 = 0;
    play();
    TEST_ASSERT_EQUAL_INT32(0, t.drive.k1_q16);
}

/// Layer 1 learns nothing in a pause, nor from a motion that is small for the scale. In a cut with
/// a chip what is in phase with the motion is the chip's, and k2 stays.
static void test_what_layer_1_learns_from_a_turn(void)
{
    static const struct {
        bool is_paused, is_chip;
        int32_t scale_nm;
        bool is_k1, is_k2, is_share;
    } cases[] = {{false, false, 0, true, true, false},
                 {true, false, 0, false, false, false},
                 {false, false, 30000, false, false, false},
                 {false, true, 0, true, false, true}};
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        settle();
        how.state = cases[i].is_chip ? cam_state_cutting : cam_state_rehearsing;
        how.z_end_nm = cases[i].is_chip ? 250000 : 0;
        play();
        t.correction.is_probed = cases[i].is_chip;
        t.correction.masked = UINT32_MAX;
        t.is_paused = cases[i].is_paused;
        t.drive = (cam_drive_t){0};
        t.best_square = UINT64_MAX;
        s.scale_nm = cases[i].scale_nm;
        along_nm = -1000.0;
        play();
        TEST_ASSERT_EQUAL(cases[i].is_k1, t.drive.k1_q16 != 0);
        TEST_ASSERT_EQUAL(cases[i].is_k2, t.drive.k2_q16 != 0);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, cases[i].is_share ? -0.005 : 0.0,
                                  t.drive.chip_q32 / 4294967296.0);
    }
}

/// A limit that was reached is that of the last turn in the rehearsal, and of the whole cut.
static void test_a_reached_limit_is_remembered_in_the_cut_alone(void)
{
    static const cam_state_t states[] = {cam_state_rehearsing, cam_state_cutting,
                                         cam_state_cutting};
    settle();
    for (int i = 0; i < 3; i++) {
        how.state = states[i];
        t.is_limited = true;
        play();
        TEST_ASSERT_EQUAL(i == 2, t.is_limited);
    }
}

/// An error 1.5 times as large as the best is still one to learn from. A larger one brings the best
/// constants back; four times, then layer 1 is given up, until the state begins anew.
static void test_the_guard_brings_the_best_back_four_times(void)
{
    settle();
    s.reason = cam_ilc_lobes;
    t.drive.k1_q16 = 1234;
    t.best_square = UINT64_MAX; // none so far
    play();
    const int32_t best_q16 = t.best.k1_q16;
    TEST_ASSERT_EQUAL_INT32(1234, best_q16);
    TEST_ASSERT_NOT_EQUAL(t.drive.k1_q16, best_q16);
    error_nm = 1490.0;
    play();
    TEST_ASSERT_EQUAL_UINT8(0, t.n_halved);
    TEST_ASSERT_NOT_EQUAL(best_q16, t.drive.k1_q16);
    error_nm = 1510.0;
    for (uint8_t strikes = 1; strikes <= 4u; strikes++) {
        t.drive.k1_q16 = 12345;
        t.drive.k2_q16 = 54321;
        play();
        TEST_ASSERT_EQUAL_UINT8(strikes, t.n_halved);
        TEST_ASSERT_EQUAL_INT32(t.best.k1_q16, t.drive.k1_q16);
        TEST_ASSERT_EQUAL_INT32(t.best.k2_q16, t.drive.k2_q16);
        TEST_ASSERT_EQUAL_INT32(best_q16, t.drive.k1_q16);
    }
    play_turns(2);
    TEST_ASSERT_EQUAL_UINT8(4, t.n_halved);
    TEST_ASSERT_EQUAL_INT32(best_q16, t.drive.k1_q16);
    TEST_ASSERT_EQUAL_UINT8(cam_ilc_diverged, t.hindrance);
    how.state = cam_state_cutting;
    play();
    TEST_ASSERT_EQUAL_UINT8(0, t.n_halved);
    TEST_ASSERT_NOT_EQUAL(best_q16, t.drive.k1_q16);
}

/// The best counts as four noise floors at least, each 1 nm here; worse is 1.5 times as much.
static void test_the_guard_ignores_what_is_within_the_noise(void)
{
    settle();
    s.reason = cam_ilc_lobes;
    error_nm = 0.0;
    play();
    TEST_ASSERT_EQUAL_UINT32(64, t.floor_q6);
    error_nm = 5.0;
    play();
    TEST_ASSERT_EQUAL_UINT8(0, t.n_halved);
    error_nm = 10.0;
    play();
    TEST_ASSERT_EQUAL_UINT8(1, t.n_halved);
}

/// Behind the probe the motion is another one: what layer 1 compared with before does not hold.
static void test_the_end_of_the_probe_lets_the_guard_begin_anew(void)
{
    play_turns(10);
    TEST_ASSERT_EQUAL_UINT8(cam_ilc_probing, t.phase);
    t.n_halved = 3;
    t.best_square = 1;
    t.trusted = UINT32_MAX;
    t.correction.best_q6[1] = 1;
    play();
    TEST_ASSERT_EQUAL_UINT8(cam_ilc_shape, t.phase);
    TEST_ASSERT_EQUAL_UINT8(0, t.n_halved);
    TEST_ASSERT_EQUAL_UINT64(UINT64_MAX, t.best_square);
    TEST_ASSERT_EQUAL_UINT32(0, t.trusted);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, t.correction.best_q6[1]);
}

/// An error that grows with the shape is no worse: 5 / 4 of the shape lets the guard begin anew.
static void test_a_larger_shape_lets_the_guard_begin_anew(void)
{
    settle();
    t.n_halved = 2;
    t.trusted = 64 * usual_set_nm * 81 / 100;
    play();
    TEST_ASSERT_EQUAL_UINT8(2, t.n_halved);
    t.trusted = 64 * usual_set_nm * 79 / 100;
    play();
    TEST_ASSERT_EQUAL_UINT8(0, t.n_halved);
    TEST_ASSERT_UINT32_WITHIN(1000, 64 * usual_set_nm, t.trusted);
}

/// While the amplitude rises the drive's constants are learned, from an eighth of it on; the turns
/// until the probe count from the full amplitude on.
static void test_the_drive_is_learned_while_the_amplitude_rises(void)
{
    how.is_level = false;
    how.scale_q30 = 1 << 26;
    play_turns(2);
    TEST_ASSERT_EQUAL_UINT8(cam_ilc_settling, t.phase);
    how.scale_q30 = 1 << 28;
    play_turns(8);
    TEST_ASSERT_EQUAL_UINT8(cam_ilc_drive, t.phase);
    const int32_t first_q16 = t.drive.k1_q16;
    TEST_ASSERT_NOT_EQUAL(0, first_q16);
    how.scale_q30 = 1 << 29;
    play();
    TEST_ASSERT_NOT_EQUAL(first_q16, t.drive.k1_q16);
    how.is_level = true;
    how.scale_q30 = 1 << 30;
    play_turns(5);
    TEST_ASSERT_EQUAL_UINT8(cam_ilc_probing, t.phase);
    how.is_level = false; // the probe waits
    const uint8_t n_steps = t.n_steps;
    play_turns(3);
    TEST_ASSERT_EQUAL_UINT8(n_steps, t.n_steps);
}

/// What does not fit U's stroke is scaled down, and reported.
static void test_corrections_are_fitted_into_the_stroke(void)
{
    t.correction.c_q6[2] = (cam_complex_t){.re = 64 * 3000, .im = 64 * 4000};
    cam_ilc_fit(&t, 6001, 100000);
    TEST_ASSERT_EQUAL_INT32(64 * 3000, t.correction.c_q6[2].re);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.01, t.chip_most_q32 / 4294967296.0);
    TEST_ASSERT_EQUAL(cam_ilc_all, cam_ilc_status(&t, &s, 20000).reason);
    cam_ilc_fit(&t, 2500, 100000);
    TEST_ASSERT_INT32_WITHIN(64, 64 * 1500, t.correction.c_q6[2].re);
    TEST_ASSERT_INT32_WITHIN(64, 64 * 2000, t.correction.c_q6[2].im);
    TEST_ASSERT_EQUAL_INT32(0, t.chip_most_q32);
    TEST_ASSERT_EQUAL(cam_ilc_limited, cam_ilc_status(&t, &s, 20000).reason);
    t.drive.k1_q16 = -400;
    t.drive.k2_q16 = 3;
    TEST_ASSERT_TRUE(cam_ilc_shrink(&t));
    TEST_ASSERT_EQUAL_INT32(-350, t.drive.k1_q16);
    TEST_ASSERT_EQUAL_INT32(0, t.drive.k2_q16);
    t.drive = (cam_drive_t){.k2_q16 = 8};
    TEST_ASSERT_TRUE(cam_ilc_shrink(&t));
    t.drive.k1_q16 = -350;
    int n = 0;
    while (cam_ilc_shrink(&t)) {
        n++;
    }
    TEST_ASSERT_TRUE(n > 5 && t.drive.k1_q16 == 0);
}

static void test_constants_stay_within_their_bounds(void)
{
    settle();
    s.k1_most_q16 = 100;
    s.k1_least_q16 = -200;
    s.k2_most_q16 = 50;
    s.k2_least_q16 = -40;
    play();
    TEST_ASSERT_EQUAL_INT32(100, t.drive.k1_q16);
    TEST_ASSERT_TRUE(t.drive.k2_q16 >= -40 && t.drive.k2_q16 <= 50);
    error_nm = -1000.0;
    t.best_square = UINT64_MAX;
    play_turns(2);
    TEST_ASSERT_EQUAL_INT32(-200, t.drive.k1_q16);
}

/// In the cut the best error ages by a sixteenth a turn, since the work changes; in the rehearsal
/// it does not. The shares of the two layers are half of the gain each once there is a shape.
static void test_the_cut_forgets_slowly(void)
{
    settle();
    play();
    const uint64_t best = t.best_square;
    play();
    TEST_ASSERT_TRUE(t.best_square <= best);
    how.state = cam_state_cutting;
    play();
    const uint64_t square = t.square;
    TEST_ASSERT_EQUAL_UINT64(square + (square >> 4), t.best_square);
    TEST_ASSERT_EQUAL_UINT8(cam_ilc_cutting, t.phase);
    t.n_steps = UINT8_MAX;
    play();
    TEST_ASSERT_EQUAL_UINT8(UINT8_MAX, t.n_steps);
}

/// The interrupt has begun to write the bank again: what was taken of the turn counts for nothing,
/// and the ripple that was summed up to it neither.
static void test_a_turn_that_is_taken_too_late_is_dropped(void)
{
    settle();
    for (uint32_t late = 0; late < 2u; late++) {
        t.bin = g.bin;
        t.turn = 5;
        t.k = 1;
        t.ripple.n = 3;
        t.ripple.sum[15] = (cam_complex_t){.re = 77, .im = 78};
        atomic_store(&g.at_q8, (6u + late) << 8);
        cam_ilc_poll(&t, &s, how.state, &g);
        TEST_ASSERT_EQUAL(late == 1u, t.bin == NULL);
        TEST_ASSERT_EQUAL_UINT32(late == 0u ? 3u : 0u, t.ripple.n);
        TEST_ASSERT_EQUAL_INT32(late == 0u ? 77 : 0, t.ripple.sum[15].re);
        TEST_ASSERT_EQUAL_INT32(late == 0u ? 78 : 0, t.ripple.sum[15].im);
    }
}

/// The correction and the constants of the smallest errors come back.
static void test_a_fault_brings_the_best_back(void)
{
    t.correction.c_q6[3] = (cam_complex_t){.re = 640, .im = -64};
    t.correction.kept_q6[3].re = 64 * 5;
    t.correction.kept_q6[3].im = 64 * 7;
    t.correction.best_q6[3] = 100;
    t.best_square = 1000;
    t.best.k1_q16 = 111;
    t.best.k2_q16 = 222;
    cam_ilc_poll(&t, &s, cam_state_fault, &g);
    TEST_ASSERT_EQUAL_INT32(5 * 64, t.correction.c_q6[3].re);
    TEST_ASSERT_EQUAL_INT32(7 * 64, t.correction.c_q6[3].im);
    TEST_ASSERT_EQUAL_INT32(111, t.drive.k1_q16);
    TEST_ASSERT_EQUAL_INT32(222, t.drive.k2_q16);
    TEST_ASSERT_BITS_HIGH(cam_ilc_blend_drive | cam_ilc_blend_correction, t.blending);
    cam_ilc_poll(&t, &s, cam_state_off, &g);
    t.best_square = UINT64_MAX; // nothing was compared yet
    t.drive.k1_q16 = 5;
    cam_ilc_poll(&t, &s, cam_state_fault, &g);
    TEST_ASSERT_EQUAL_INT32(5, t.drive.k1_q16);
}

/// What is in force is not yet what is known.
static void test_a_probe_cut_short_is_walked_away_from(void)
{
    t.state = cam_state_rehearsing;
    t.phase = cam_ilc_probing;
    t.correction.c_q6[2].re = 64 * 500;
    t.blending = 0;
    cam_ilc_poll(&t, &s, cam_state_ready, &g);
    TEST_ASSERT_EQUAL_INT32(0, t.correction.c_q6[2].re);
    TEST_ASSERT_BITS_HIGH(cam_ilc_blend_correction, t.blending);
}

/// Each single value is something that is forgotten, and without one nothing walks.
static void test_what_is_forgotten_is_walked_away_from(void)
{
    int32_t *const values[] = {&t.speed_q32,         &t.drive.k1_q16,   &t.drive.k2_q16,
                               &t.drive.friction_q6, &t.drive.chip_q32, &t.chip_mean_q32};
    for (size_t i = 0; i <= 12u; i++) { // each of the six above and below 0
        const bool is_none = i == 12u;
        *values[i % 6u] = is_none ? 0 : i < 6u ? 1 : -1;
        t.correction.c_q6[3].re = 64;
        t.blending = 0;
        cam_ilc_forget(&t);
        TEST_ASSERT_EQUAL_HEX8(is_none ? 0 : cam_ilc_blend_drive | cam_ilc_blend_correction,
                               t.blending);
        TEST_ASSERT_EQUAL_INT32(0, *values[i % 6u]);
        TEST_ASSERT_EQUAL_INT32(0, t.correction.c_q6[3].re);
    }
}
