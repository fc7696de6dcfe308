// SPDX-License-Identifier: Apache-2.0
// The correction of a harmonic: its probe, its guard and what it forgets, against MATHS.md
// (142) .. (144) in double.
#include "cam_harmonic_correction.h"
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

static void test_play_puts_a_chirp_up_to_n_and_nothing_above(void)
{
    for (uint32_t n = 1; n <= cam_harmonics_most; n *= 2u) {
        cam_harmonic_correction_set_probe(&s, 64000, n, UINT32_MAX);
        for (uint32_t k = 0; k < cam_harmonic_terms; k++) {
            const double size = k <= n ? 64000.0 : 0.0, angle = 3.14159265358979323846 * k * k / n;
            TEST_ASSERT_INT32_WITHIN(1, lround(size * cos(angle)), s.c_q6[k].re);
            TEST_ASSERT_INT32_WITHIN(1, lround(size * sin(angle)), s.c_q6[k].im);
        }
    }
}

static void test_play_of_some_leaves_the_others_alone(void)
{
    cam_harmonic_correction_set_probe(&s, 64000, 16, 1u << 3 | 1u << 7);
    for (uint32_t k = 0; k < cam_harmonic_terms; k++) {
        TEST_ASSERT_UINT32_WITHIN(2, k == 3u || k == 7u ? 64000 : 0, cam_complex_size(s.c_q6[k]));
    }
}

static void test_play_of_nothing_ends_the_probe(void)
{
    cam_harmonic_correction_set_probe(&s, 6400, 16, UINT32_MAX);
    TEST_ASSERT_NOT_EQUAL(0, cam_harmonic_correction_sum_q6(&s));
    cam_harmonic_correction_set_probe(&s, 0, 16, UINT32_MAX);
    TEST_ASSERT_EQUAL_UINT32(0, cam_harmonic_correction_sum_q6(&s));
}

/// Probe harmonic 3 with two corrections, to which U answers by `first` and `second` per mille.
static void probe(int32_t first, int32_t second)
{
    const cam_complex_t before = of(64 * 900, 64 * -700);
    cam_harmonic_correction_probe(&s, 0, 3, before);
    s.c_q6[3] = of(64000, 0);
    cam_harmonic_correction_probe(&s, 1, 3, of(before.re - 64 * first, before.im));
    s.c_q6[3] = of(128000, 0);
    cam_harmonic_correction_probe(&s, 2, 3, of(before.re - 128 * second, before.im));
}

static void test_probe_learns_how_u_answers(void)
{
    probe(1000, 1000);
    TEST_ASSERT_EQUAL_INT16(4096, s.gain[3].re_q12);
    TEST_ASSERT_EQUAL_INT16(0, s.gain[3].im_q12);
    TEST_ASSERT_EQUAL_UINT32(0, s.masked);
}

/// A third probe, five times as large as the first, of harmonic 3.
static void probe_again(int32_t third)
{
    s.c_q6[3] = of(320000, 0);
    cam_harmonic_correction_probe(&s, 3, 3, of(64 * 900 - 320 * third, 64 * -700));
}

static void test_larger_probe_unmasks_what_agrees_with_the_one_before(void)
{
    probe(500, 800);
    TEST_ASSERT_EQUAL_UINT32(1u << 3, s.masked);
    probe_again(900);
    TEST_ASSERT_EQUAL_UINT32(0, s.masked);
    TEST_ASSERT_INT16_WITHIN(1, 3686, s.gain[3].re_q12);
    setUp();
    probe(300, 500);
    probe_again(800); // still out of proportion
    TEST_ASSERT_EQUAL_UINT32(1u << 3, s.masked);
}

static void test_larger_probe_does_not_change_what_was_known(void)
{
    probe(1000, 1000);
    probe_again(500);
    TEST_ASSERT_EQUAL_UINT32(0, s.masked);
    TEST_ASSERT_EQUAL_INT16(4096, s.gain[3].re_q12);
}

/// Harmonic k answers by one.
static void answer(uint32_t k)
{
    s.gain[k].re_q12 = cam_gain_one_q12;
}

static void learn(uint32_t k, cam_complex_t error_q6)
{
    uint32_t room_q6 = 1u << 20;
    cam_harmonic_correction_learn(&s, k, error_q6, 64, 1 << 15, &room_q6);
}

static void test_probe_without_a_correction_keeps_the_answer(void)
{
    s.gain[3].re_q12 = 1234;
    cam_harmonic_correction_probe(&s, 0, 3, of(640, 0));
    TEST_ASSERT_EQUAL_INT16(1234, s.gain[3].re_q12);
}

static void test_guard_keeps_the_older_of_two_equals(void)
{
    answer(2);
    learn(2, of(640, 0));
    learn(2, of(640, 0));
    cam_harmonic_correction_restore(&s);
    expect(of(0, 0), s.c_q6[2]);
}

static void test_probe_masks_what_answers_too_little(void)
{
    probe(95, 95);
    TEST_ASSERT_EQUAL_UINT32(1u << 3, s.masked);
    setUp();
    probe(105, 105);
    TEST_ASSERT_EQUAL_UINT32(0, s.masked);
}

static void test_probe_masks_what_answers_out_of_proportion(void)
{
    probe(790, 1000);
    TEST_ASSERT_EQUAL_UINT32(1u << 3, s.masked);
    setUp();
    probe(810, 1000);
    TEST_ASSERT_EQUAL_UINT32(0, s.masked);
}

static void test_learn_adds_its_part_of_the_error(void)
{
    answer(2);
    learn(2, of(6400, -3200));
    expect(of(3200, -1600), s.c_q6[2]);
    learn(2, of(3200, -1600));
    expect(of(4800, -2400), s.c_q6[2]);
    expect(of(0, 0), s.c_q6[1]);
}

static void test_learn_divides_the_error_by_the_response(void)
{
    uint32_t room_q6 = UINT32_MAX;
    const double complex response = (2048.0 - 3000.0 * I) / 4096.0;
    const double complex want = 0.5 * (640000.0 - 123456.0 * I) / response;
    s.gain[0] = (cam_gain_t){.re_q12 = 2048, .im_q12 = -3000};
    cam_harmonic_correction_learn(&s, 0, of(640000, -123456), 0, 32768, &room_q6);
    TEST_ASSERT_INT32_WITHIN(2, (int32_t)lround(creal(want)), s.c_q6[0].re);
    TEST_ASSERT_INT32_WITHIN(2, (int32_t)lround(cimag(want)), s.c_q6[0].im);
    s.gain[1] = (cam_gain_t){0}; // no response: nothing can be corrected
    cam_harmonic_correction_learn(&s, 1, of(64, 0), 0, 65536, &room_q6);
    expect(of(0, 0), s.c_q6[1]);
}

/// The ends of the range, under the sanitizers.
static void test_largest_error_over_the_smallest_response_fits(void)
{
    uint32_t room_q6 = UINT32_MAX;
    s.gain[0] = (cam_gain_t){.re_q12 = 1};
    cam_harmonic_correction_learn(&s, 0, of(INT32_MAX, INT32_MIN + 1), 0, 65536, &room_q6);
    expect(of(1 << 30, -(1 << 30)), s.c_q6[0]);
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

static void test_guard_goes_back_to_the_best_and_halves(void)
{
    answer(2);
    learn(2, of(6400, 0)); // best: 0 corrected
    learn(2, of(3200, 0)); // best: 3200
    expect(of(4800, 0), s.c_q6[2]);
    learn(2, of(4803, 0)); // more than half as much again
    expect(of(3200, 0), s.c_q6[2]);
    TEST_ASSERT_EQUAL_UINT8(1, s.n_halved[2]);
    TEST_ASSERT_EQUAL_UINT32(3200, s.best_q6[2]);
    learn(2, of(4800, 0)); // just half as much again: learned, by half
    expect(of(4400, 0), s.c_q6[2]);
    TEST_ASSERT_EQUAL_UINT8(1, s.n_halved[2]);
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

/// An error that doubles in a turn has a new cause: the guard compares with it from then on. One
/// that doubles again comes from learning itself.
static void test_guard_starts_anew_when_the_cause_is_new(void)
{
    answer(2);
    learn(2, of(640, 0));
    learn(2, of(64000, 0));
    expect(of(32320, 0), s.c_q6[2]);
    TEST_ASSERT_EQUAL_UINT32(128000, s.best_q6[2]); // half of it may have shown
    learn(2, of(192000, 0));
    TEST_ASSERT_EQUAL_UINT8(0, s.n_halved[2]);
    for (uint32_t i = 1; i <= 4; i++) {
        learn(2, of(193000, 0));
        TEST_ASSERT_EQUAL_UINT8(i, s.n_halved[2]);
    }
    setUp();
    answer(2);
    learn(2, of(640, 0));
    learn(2, of(6400, 0));
    learn(2, of(64000, 0)); // doubles again
    TEST_ASSERT_EQUAL_UINT8(1, s.n_halved[2]);
    expect(of(320, 0), s.c_q6[2]);
}

static void test_guard_asks_for_no_less_than_the_floor(void)
{
    answer(2);
    learn(2, of(6, 0));
    learn(2, of(96, 0)); // one and a half times the floor
    TEST_ASSERT_EQUAL_UINT8(0, s.n_halved[2]);
    learn(2, of(99, 0));
    TEST_ASSERT_EQUAL_UINT8(1, s.n_halved[2]);
}

static void test_mean_is_not_guarded(void)
{
    answer(0);
    learn(0, of(640, 0));
    learn(0, of(64000, 0));
    expect(of(32320, 0), s.c_q6[0]);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, s.best_q6[0]);
}

static void test_the_first_harmonic_is_guarded(void)
{
    answer(1);
    learn(1, of(640, 0));
    learn(1, of(1100, 0));
    expect(of(0, 0), s.c_q6[1]);
    TEST_ASSERT_EQUAL_UINT8(1, s.n_halved[1]);
    TEST_ASSERT_EQUAL_UINT32(640, s.best_q6[1]);
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

static void test_sum_is_that_of_all_magnitudes(void)
{
    s.c_q6[0] = of(-100, 0);
    s.c_q6[1] = of(300, -400);
    s.c_q6[cam_harmonics_most] = of(0, 1000);
    TEST_ASSERT_EQUAL_UINT32(1600, cam_harmonic_correction_sum_q6(&s));
}

static void test_turn_takes_what_is_kept_along_and_leaves_the_mean(void)
{
    for (uint32_t k = 0; k < cam_harmonic_terms; k++) {
        s.c_q6[k] = of(6400, 0);
        s.kept[k].re_nm = 100;
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
