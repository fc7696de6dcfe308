// SPDX-License-Identifier: Apache-2.0
// The correction of a harmonic: its probe, its guard and what it forgets, against MATHS.md
// (142) .. (144) in double.
#include "cam_learning_inner.h"
#include "unity.h"
#include <complex.h>
#include <math.h>
#include <string.h>

static cam_harmonic_correction_t s;

void setUp(void)
{
    (void)memset(&s, 0x5a, sizeof s);
    cam_harmonic_correction_forget(&s);
}

static cam_complex_t of(int32_t re, int32_t im)
{
    return (cam_complex_t){.re = re, .im = im};
}

static void expect(cam_complex_t want, cam_complex_t is)
{
    TEST_ASSERT_EQUAL_INT32(want.re, is.re);
    TEST_ASSERT_EQUAL_INT32(want.im, is.im);
}

/// Of some harmonics the others are left alone; a size of 0 ends the probe.
static void test_probe_is_a_chirp_up_to_n_and_nothing_above(void)
{
    static const uint32_t of_which[] = {UINT32_MAX, 1u << 3 | 1u << 7};
    for (uint32_t i = 0; i < 10u; i++) {
        const uint32_t n = 1u << i / 2u, which = of_which[i % 2u];
        setUp();
        cam_harmonic_correction_set_probe(&s, 64000, n, which);
        for (uint32_t k = 0; k < cam_ilc_terms; k++) {
            const double size = k <= n && (which >> k & 1u) != 0u ? 64000.0 : 0.0;
            const double angle = 3.14159265358979323846 * k * k / n;
            TEST_ASSERT_INT32_WITHIN(1, lround(size * cos(angle)), s.c_q6[k].re);
            TEST_ASSERT_INT32_WITHIN(1, lround(size * sin(angle)), s.c_q6[k].im);
        }
        cam_harmonic_correction_set_probe(&s, 0, n, which);
        TEST_ASSERT_EQUAL_UINT32(0, cam_harmonic_correction_sum_q6(&s));
    }
}

/// Probe harmonic 3 with two corrections, to which U answers by `first` and `second` per mille.
static void probe(int32_t first, int32_t second)
{
    const cam_complex_t before = of(64 * 900, 64 * -700);
    cam_harmonic_correction_probe(&s, 0, 3, before);
    s.c_q6[3] = of(64000, 0);
    cam_harmonic_correction_probe(&s, 1, 3, of(before.re - 64 * first, before.im));
    TEST_ASSERT_EQUAL_HEX32(0, s.masked); // one answer alone masks nothing
    s.c_q6[3] = of(128000, 0);
    cam_harmonic_correction_probe(&s, 2, 3, of(before.re - 128 * second, before.im));
}

/// Too small an answer masks the harmonic, and one that is out of proportion; a third, larger probe
/// unmasks what agrees with the one before, and changes nothing that is known.
static void test_probe_learns_how_u_answers(void)
{
    static const struct {
        int32_t first, second, third; ///< [per mille] answers; 0: no third probe
        bool is_masked;
        int16_t gain_q12;
    } cases[] = {
        {1000, 1000, 0, false, 4096}, {1000, 1000, 500, false, 4096}, {105, 105, 0, false, 430},
        {95, 95, 0, true, 0},         {810, 1000, 0, false, 4096},    {790, 1000, 0, true, 0},
        {500, 800, 0, true, 0},       {500, 800, 900, false, 3686},   {300, 500, 800, true, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        setUp();
        probe(cases[i].first, cases[i].second);
        if (cases[i].third > 0) {
            s.c_q6[3] = of(320000, 0); // five times as large as the first
            cam_harmonic_correction_probe(&s, 3, 3, of(64 * 900 - 320 * cases[i].third, 64 * -700));
        }
        TEST_ASSERT_EQUAL_HEX32(cases[i].is_masked ? 1u << 3 : 0u, s.masked);
        if (!cases[i].is_masked) {
            TEST_ASSERT_INT16_WITHIN(1, cases[i].gain_q12, s.gain[3].re);
            TEST_ASSERT_EQUAL_INT16(0, s.gain[3].im);
        }
    }
}

/// Harmonic k answers by one.
static void answer(uint32_t k)
{
    s.gain[k].re = cam_gain_one_q12;
}

static void learn(uint32_t k, cam_complex_t error_q6)
{
    uint32_t room_q6 = 1u << 20;
    cam_harmonic_correction_learn(&s, k, error_q6, 64, 1 << 15, &room_q6);
}

static void test_probe_without_a_correction_keeps_the_answer(void)
{
    s.gain[3].re = 1234;
    cam_harmonic_correction_probe(&s, 0, 3, of(640, 0));
    TEST_ASSERT_EQUAL_INT16(1234, s.gain[3].re);
}

static void test_learn_divides_the_error_by_the_response(void)
{
    uint32_t room_q6 = UINT32_MAX;
    const double complex response = (2048.0 - 3000.0 * I) / 4096.0;
    const double complex want = 0.5 * (640000.0 - 123456.0 * I) / response;
    s.gain[0] = (cam_complex_t){.re = 2048, .im = -3000};
    cam_harmonic_correction_learn(&s, 0, of(640000, -123456), 0, 32768, &room_q6);
    TEST_ASSERT_INT32_WITHIN(2, (int32_t)lround(creal(want)), s.c_q6[0].re);
    TEST_ASSERT_INT32_WITHIN(2, (int32_t)lround(cimag(want)), s.c_q6[0].im);
    s.gain[1] = (cam_complex_t){0}; // no response: nothing can be corrected
    cam_harmonic_correction_learn(&s, 1, of(64, 0), 0, 65536, &room_q6);
    expect(of(0, 0), s.c_q6[1]);
}

/// The ends of the range, under the sanitizers.
static void test_largest_error_over_the_smallest_response_fits(void)
{
    uint32_t room_q6 = UINT32_MAX;
    s.gain[0] = (cam_complex_t){.re = 1};
    cam_harmonic_correction_learn(&s, 0, of(INT32_MAX, INT32_MIN + 1), 0, 65536, &room_q6);
    expect(of(1 << 30, -(1 << 30)), s.c_q6[0]);
}

static void test_best_is_kept_to_the_nearest_nanometre(void)
{
    static const struct {
        int32_t q6;
        int16_t nm;
    } cases[] = {{31, 0}, {32, 1}, {95, 1}, {96, 2}, {-32, 0}, {-33, -1}, {3000000, INT16_MAX}};
    answer(2);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        cam_harmonic_correction_restart_guard(&s);
        s.c_q6[2] = of(cases[i].q6, 0);
        learn(2, of(640, 0));
        TEST_ASSERT_EQUAL_INT32(64 * cases[i].nm, s.kept_q6[2].re);
    }
}

static void test_learn_leaves_a_masked_harmonic_alone(void)
{
    answer(2);
    s.masked = 1u << 2;
    learn(2, of(6400, 0));
    expect(of(0, 0), s.c_q6[2]);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, s.best_q6[2]);
    answer(3);
    learn(3, of(6400, 0));
    expect(of(3200, 0), s.c_q6[3]);
}

/// What does not fit is scaled to the room; what shrinks needs none.
static void test_learn_scales_a_change_to_the_room(void)
{
    uint32_t room_q6 = 3200;
    answer(2);
    cam_harmonic_correction_learn(&s, 2, of(4800, 0), 64, 1 << 15, &room_q6);
    expect(of(2400, 0), s.c_q6[2]);
    TEST_ASSERT_EQUAL_UINT32(800, room_q6);
    answer(3);
    cam_harmonic_correction_learn(&s, 3, of(6000, -8000), 64, 1 << 15, &room_q6);
    expect(of(480, -640), s.c_q6[3]);
    TEST_ASSERT_EQUAL_UINT32(0, room_q6);
    cam_harmonic_correction_learn(&s, 2, of(-3200, 0), 64, 1 << 15, &room_q6);
    expect(of(800, 0), s.c_q6[2]);
    cam_harmonic_correction_learn(&s, 2, of(3200, 0), 64, 1 << 15, &room_q6);
    expect(of(800, 0), s.c_q6[2]);
}

/// An error that is more than half as much again as the best brings the best back, of two equals
/// the older one, and halves the steps. Below the floor it does not, nor does it for the mean.
static void test_guard_goes_back_to_the_best_and_halves(void)
{
    static const struct {
        uint32_t k;
        int32_t error[4], c;
        uint32_t best, n_halved;
    } cases[] = {
        {2, {6400, 3200}, 4800, 3200, 0},
        {2, {6400, 3200, 4803}, 3200, 3200, 1},
        {2, {6400, 3200, 4803, 4800}, 4400, 3200, 1}, // just half as much again: learned, by half
        {2, {640, 640, 1100}, 0, 640, 1},
        {1, {640, 1100}, 0, 640, 1},
        {2, {6, 96}, 51, 6, 0}, // one and a half times the floor
        {2, {6, 96, 99}, 0, 6, 1},
        {0, {640, 64000}, 32320, UINT32_MAX, 0},
        {2, {640, 64000}, 32320, 128000, 0}, // a new cause, of which half may have shown
        {2, {640, 64000, 192000}, 128320, 128000, 0},
        {2, {6, 20, 6400}, 3213, 12800, 0},     // likewise after noise that has doubled
        {2, {640, 6400, 64000}, 320, 12800, 1}, // doubles again
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        setUp();
        answer(cases[i].k);
        for (size_t j = 0; j < 4u && cases[i].error[j] != 0; j++) {
            learn(cases[i].k, of(cases[i].error[j], 0));
        }
        expect(of(cases[i].c, 0), s.c_q6[cases[i].k]);
        TEST_ASSERT_EQUAL_UINT32(cases[i].best, s.best_q6[cases[i].k]);
        TEST_ASSERT_EQUAL_UINT8(cases[i].n_halved, s.n_halved[cases[i].k]);
    }
}

static void test_guard_masks_at_the_fourth_time(void)
{
    answer(2);
    learn(2, of(640, 0));
    for (uint32_t i = 1; i <= 4; i++) {
        TEST_ASSERT_EQUAL_UINT32(0, s.masked);
        learn(2, of(1100, 0));
        TEST_ASSERT_EQUAL_UINT8(i, s.n_halved[2]);
    }
    TEST_ASSERT_EQUAL_UINT32(1u << 2, s.masked);
    cam_harmonic_correction_restart_guard(&s);
    TEST_ASSERT_EQUAL_UINT8(0, s.n_halved[2]);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, s.best_q6[2]);
}

static void test_best_ages_by_a_sixteenth(void)
{
    s.best_q6[1] = 1600;
    s.best_q6[2] = 0;
    cam_harmonic_correction_age(&s, 1);
    cam_harmonic_correction_age(&s, 2);
    cam_harmonic_correction_age(&s, 3);
    TEST_ASSERT_EQUAL_UINT32(1701, s.best_q6[1]);
    TEST_ASSERT_EQUAL_UINT32(1, s.best_q6[2]);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, s.best_q6[3]); // nothing yet that could age
}

static void test_restore_goes_back_where_something_is_known(void)
{
    answer(2);
    learn(2, of(6400, 0));
    learn(2, of(3200, 0));
    s.c_q6[5] = of(77, 78);
    cam_harmonic_correction_restore(&s);
    expect(of(3200, 0), s.c_q6[2]);
    expect(of(77, 78), s.c_q6[5]);
}

static void test_turn_takes_what_is_kept_along_and_leaves_the_mean(void)
{
    for (uint32_t k = 0; k < cam_ilc_terms; k++) {
        s.c_q6[k] = of(6400, 0);
        s.kept_q6[k].re = 6400;
        s.best_q6[k] = 1;
    }
    cam_harmonic_correction_rotate(&s, UINT32_C(1)
                                           << 28); // a sixteenth of a turn: harmonic 4 by a quarter
    expect(of(6400, 0), s.c_q6[0]);
    TEST_ASSERT_INT32_WITHIN(2, 6400, s.c_q6[4].im);
    TEST_ASSERT_INT32_WITHIN(2, -6400, s.c_q6[8].re);
    TEST_ASSERT_INT32_WITHIN(2, 6400, s.c_q6[16].re);
    cam_harmonic_correction_restore(&s);
    TEST_ASSERT_INT32_WITHIN(64, 6400, s.c_q6[4].im);
    TEST_ASSERT_INT32_WITHIN(64, -6400, s.c_q6[8].re);
}
