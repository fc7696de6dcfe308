// SPDX-License-Identifier: Apache-2.0
// The ripple of a spindle from the bins of its turns: orders, drift of the speed, counts.
#include "cam_learning_inner.h" // cam_ripple_t, cam_ripple_add, cam_ripple_close
#include "unity.h"
#include <math.h>

#define TURN 6.283185307179586

static cam_turn_bin_t bin[cam_turn_bins_n];

/// One turn of 401.3 ticks with ripple of the orders 2 and 5, in a speed that drifts by a share per
/// turn.
static void fill(double drift)
{
    for (int i = 0; i < cam_turn_bins_n; i++) {
        bin[i] = (cam_turn_bin_t){0};
    }
    const double ticks = 401.3;
    for (int i = 0; i < 410; i++) {
        const double t = (i + 0.4) / ticks;
        const double even = t + 0.5 * drift * t * (t - 1.0);
        const double turn = even + 1e-4 * sin(2.0 * TURN * even) + 3e-5 * cos(5.0 * TURN * even);
        if (turn < 0.0 || turn >= 1.0) {
            continue;
        }
        const int b = (int)(turn * cam_turn_bins_n);
        bin[b].n++;
        bin[b].angle_q24 += (int32_t)lround((turn - (double)b / cam_turn_bins_n) * 16777216.0);
    }
}

static int32_t q32(double turns)
{
    return (int32_t)lround(turns * 4294967296.0);
}

/// The orders of a ripple are found; a drift of the speed is none. The speed of the last turn is
/// what the first one's was and what drifted since.
static void test_orders_are_found_and_a_drift_of_the_speed_is_none(void)
{
    static const double drifts[] = {0.0, 0.002};
    for (int n = 0; n < 2; n++) {
        cam_ripple_t r = {0};
        bool is_new = false;
        for (int i = 0; i < 4; i++) {
            fill(drifts[n]);
            const int32_t speed_q36 = cam_ripple_deviate(bin);
            const int32_t even_q36 = (int32_t)lround(68719476736.0 / 401.3);
            TEST_ASSERT_INT32_WITHIN(n == 0 ? even_q36 / 100000 : even_q36 / 100, even_q36,
                                     speed_q36);
            for (uint32_t k = 1; k <= 16u; k++) {
                cam_ripple_add(&r, k, cam_harmonics_of(&bin[0].angle_q24, sizeof bin[0] / 4u, k));
            }
            is_new = cam_ripple_close(&r, 4, 0, (int32_t)lround(speed_q36 * (1.0 + drifts[n] * i)));
        }
        TEST_ASSERT_TRUE(is_new);
        const double within = n == 0 ? 3e-6 : 5e-6;
        TEST_ASSERT_INT32_WITHIN(q32(within), 0, cam_ripple_order(&r, 1).re);
        TEST_ASSERT_INT32_WITHIN(q32(within), 0, cam_ripple_order(&r, 2).re);
        TEST_ASSERT_INT32_WITHIN(q32(within), q32(-1e-4), cam_ripple_order(&r, 2).im);
        TEST_ASSERT_INT32_WITHIN(q32(within), q32(3e-5), cam_ripple_order(&r, 5).re);
    }
}

static void test_a_turn_with_a_hole_or_a_jump_is_refused(void)
{
    fill(0.0);
    bin[17].n = 0;
    TEST_ASSERT_EQUAL_INT32(0, cam_ripple_deviate(bin));
    fill(0.0);
    bin[60].angle_q24 += 1 << 22;
    TEST_ASSERT_EQUAL_INT32(0, cam_ripple_deviate(bin));
}

/// The largest deviation that a turn can show, as often as the parameter allows.
static void test_a_sum_beyond_its_word_keeps_its_sign(void)
{
    cam_ripple_t r = {0};
    const cam_complex_t large = {.re = 1 << 26, .im = -(1 << 26)};
    for (int turn = 0; turn < 64; turn++) {
        cam_ripple_add(&r, 1, large);
        (void)cam_ripple_close(&r, 64, 0, 1 << 28);
    }
    TEST_ASSERT_EQUAL_INT32(cam_ripple_most, r.mean[0].re);
    TEST_ASSERT_EQUAL_INT32(-cam_ripple_most, r.mean[0].im);
    TEST_ASSERT_UINT32_WITHIN(1, 23169, cam_ripple_sum(&r)); // root 2 times that
}

/// No mean is reported before all of its turns are added; the next mean begins without them.
static void test_a_mean_is_made_of_its_turns_and_begins_anew(void)
{
    cam_ripple_t r = {0};
    const int32_t least = 1000;
    for (int turn = 0; turn < 4; turn++) {
        cam_ripple_add(&r, 3, (cam_complex_t){.re = 512 * (10 + turn), .im = -512 * 8});
        TEST_ASSERT_EQUAL(turn == 3, cam_ripple_close(&r, 4, least, 1 << 26));
        TEST_ASSERT_EQUAL_UINT32(turn < 3 ? 0 : 4, r.n_mean);
        TEST_ASSERT_EQUAL_UINT32((turn + 1) % 4, r.n);
    }
    TEST_ASSERT_EQUAL_INT32(12 * 512, cam_ripple_order(&r, 3).re); // 11.5, rounded
    TEST_ASSERT_EQUAL_INT32(-8 * 512, cam_ripple_order(&r, 3).im);
    cam_ripple_add(&r, 3, (cam_complex_t){.re = 512 * 100});
    TEST_ASSERT_FALSE(cam_ripple_close(&r, 3, least, 1 << 27));
    cam_ripple_drop(&r);
    TEST_ASSERT_EQUAL_INT32(12 * 512, cam_ripple_order(&r, 3).re);
    cam_ripple_add(&r, 3, (cam_complex_t){.re = 512 * 4, .im = 512 * 3});
    TEST_ASSERT_TRUE(cam_ripple_close(&r, 1, least, 1 << 25));
    TEST_ASSERT_EQUAL_INT32(4 * 512, cam_ripple_order(&r, 3).re);
    TEST_ASSERT_EQUAL_INT32(3 * 512, cam_ripple_order(&r, 3).im);
    TEST_ASSERT_EQUAL_UINT32(1, r.n_mean);
    TEST_ASSERT_EQUAL_INT32(0, r.sum[2].re);
}

/// An order of just the magnitude that the counts can feign is reported as 0.
static void test_the_least_reported_order_exceeds_what_counts_feign(void)
{
    cam_ripple_t r = {0};
    const cam_complex_t five = {.re = 3 * 512, .im = -4 * 512};
    cam_ripple_add(&r, 2, five);
    TEST_ASSERT_TRUE(cam_ripple_close(&r, 1, 5 * 512, 1 << 26));
    TEST_ASSERT_EQUAL_INT32(0, cam_ripple_order(&r, 2).re);
    TEST_ASSERT_EQUAL_INT32(0, cam_ripple_order(&r, 2).im);
    for (int turn = 0; turn < 2; turn++) {
        cam_ripple_add(&r, 2, five);
        (void)cam_ripple_close(&r, 2, 5 * 512 - 1, 1 << 26);
    }
    TEST_ASSERT_EQUAL_INT32(3 * 512, cam_ripple_order(&r, 2).re);
    TEST_ASSERT_EQUAL_INT32(-4 * 512, cam_ripple_order(&r, 2).im);
}

/// A drift of d per turn leaves d / (2 pi^2) in order 1, and 1 / k^2 of that in order k, real.
static void test_drift_is_taken_off_by_the_square_of_the_order(void)
{
    cam_ripple_t r = {0};
    const int32_t last_q36 = 1 << 27;
    const double per_turn = 0.002;
    for (int turn = 0; turn < 3; turn++) {
        (void)cam_ripple_close(&r, 3, 0, last_q36 - (int32_t)((2 - turn) * per_turn * last_q36));
    }
    const double first = -per_turn * 4294967296.0 / (TURN * TURN / 2.0);
    for (uint32_t k = 1; k <= 16u; k++) {
        TEST_ASSERT_INT32_WITHIN(400, (int32_t)lround(first / (k * k)), cam_ripple_order(&r, k).re);
        TEST_ASSERT_EQUAL_INT32(0, cam_ripple_order(&r, k).im);
    }
}

/// Fewer ticks than bins leave one of them empty.
static void test_a_turn_of_few_ticks_has_no_ripple(void)
{
    const cam_turn_bin_t one = {.n = 1, .angle_q24 = 65536};
    for (int i = 0; i < cam_turn_bins_n; i++) {
        bin[i] = one;
    }
    const int64_t speed_q36 = INT64_C(68719476736) / cam_turn_bins_n;
    TEST_ASSERT_INT64_WITHIN(1, speed_q36, cam_ripple_deviate(bin));
    for (int i = 0; i < cam_turn_bins_n; i++) {
        TEST_ASSERT_EQUAL_INT32(bin[0].angle_q24, bin[i].angle_q24); // even, but for a constant
    }
    for (int i = 0; i < cam_turn_bins_n; i++) {
        bin[i] = one;
    }
    bin[5] = (cam_turn_bin_t){.n = 2, .angle_q24 = 2 * 65536};
    bin[100].n = 0;
    TEST_ASSERT_EQUAL_INT32(0, cam_ripple_deviate(bin));
}
