// SPDX-License-Identifier: Apache-2.0
// Layer 1 finds constants that are wrong: against the equations in floating point.
#include "cam_learning_inner.h" // cam_drive_sums_t, cam_drive_add, cam_drive_t
#include "unity.h"
#include <complex.h>
#include <math.h>

#define TURN 6.283185307179586

enum { speed_q32 = 10737418 }; // 3000 r/min at 20 kHz

static const double k1_ticks = 14.9, k2_ticks2 = 112.6;

static double omega(uint32_t k)
{
    return TURN * k * speed_q32 / 4294967296.0;
}

static double complex response(uint32_t k)
{
    const double w = omega(k);
    return 1.0 / (1.0 + I * w * k1_ticks - w * w * k2_ticks2);
}

static int32_t q16(double ticks)
{
    return (int32_t)lround(ticks * 65536.0);
}

static cam_complex_t fixed(double complex value)
{
    return (cam_complex_t){.re = (int32_t)lround(creal(value)),
                           .im = (int32_t)lround(cimag(value))};
}

static void test_the_answer_of_the_drive_is_that_of_its_constants(void)
{
    for (uint32_t k = 1; k <= 16u; k++) {
        const cam_complex_t g = cam_drive_gain(k, speed_q32, q16(k1_ticks), q16(k2_ticks2));
        TEST_ASSERT_INT32_WITHIN(16, (int32_t)lround(4096.0 * creal(response(k))), g.re);
        TEST_ASSERT_INT32_WITHIN(16, (int32_t)lround(4096.0 * cimag(response(k))), g.im);
    }
}

/// Friction leaves its size times the sense of the motion, filtered by the drive. Two harmonics of
/// a square wave suffice; a faint one determines nothing.
static void test_friction_is_found_from_the_sense_of_the_motion(void)
{
    static const double friction_q6[] = {64.0 * 4000.0, -64.0 * 30.0};
    for (int i = 0; i < 2; i++) {
        cam_drive_sums_t sums = {0};
        for (uint32_t k = 6; k <= 10u; k += 4u) {
            const double complex sense = 4.0 / 3.14159265 / (k / 2u) * cexp(I * 0.7 * k);
            const cam_complex_t g = cam_drive_gain(k, speed_q32, q16(k1_ticks), q16(k2_ticks2));
            cam_friction_add(&sums, fixed(friction_q6[i] * sense * response(k)),
                             fixed(1048576.0 * sense), g);
        }
        const cam_drive_t by = cam_drive_solve(&sums, speed_q32);
        TEST_ASSERT_INT32_WITHIN(1 + (int32_t)fabs(friction_q6[i] / 100.0), (int32_t)friction_q6[i],
                                 by.friction_q6);
    }
    for (int32_t more = 0; more < 2; more++) {
        cam_drive_sums_t faint = {0};
        cam_friction_add(&faint, (cam_complex_t){.re = 6400},
                         (cam_complex_t){.re = (1 << 17) - 1 + more}, (cam_complex_t){.re = 4096});
        TEST_ASSERT_EQUAL_INT32(more * 51200, cam_drive_solve(&faint, speed_q32).friction_q6);
    }
}

/// The error that wrong constants leave is U G (j w dk1 - w^2 dk2). The chip's force leaves a share
/// of U's set-point, filtered by the drive, in every harmonic, of which a quarter at most is
/// believed.
static void test_wrong_constants_and_the_chip_are_found_from_their_error(void)
{
    static const double dk1[] = {0.5, -1.0, 0.0, 0.02, 0.0, 0.0, 0.0, 0.0};
    static const double dk2[] = {-4.0, 0.0, 6.0, 0.1, 0.0, 0.0, 0.0, 0.0};
    static const double share[] = {0.0, 0.0, 0.0, 0.0, 0.03, -0.002, 0.2, 0.5};
    for (int i = 0; i < 8; i++) {
        cam_drive_sums_t sums = {0};
        for (uint32_t k = 2; k <= 6u; k += 2u) {
            const double complex u = 32e6 / (k * k) * cexp(I * 0.3 * k);
            const double w = omega(k);
            const double complex e = u * response(k) * (share[i] + I * w * dk1[i] - w * w * dk2[i]);
            const cam_complex_t g = cam_drive_gain(k, speed_q32, q16(k1_ticks), q16(k2_ticks2));
            cam_drive_add(&sums, k, fixed(e), fixed(u), g);
        }
        const cam_drive_t by = cam_drive_solve(&sums, speed_q32);
        TEST_ASSERT_INT32_WITHIN(800, q16(dk1[i]), by.k1_q16);
        if (share[i] == 0.0) {
            TEST_ASSERT_INT32_WITHIN(12000, q16(dk2[i]), by.k2_q16);
        } else {
            TEST_ASSERT_DOUBLE_WITHIN(1e-5 + fabs(share[i]) / 200.0, fmin(share[i], 0.25),
                                      by.chip_q32 / 4294967296.0);
        }
    }
    const cam_drive_sums_t nothing = {0};
    const cam_drive_t none = cam_drive_solve(&nothing, speed_q32);
    TEST_ASSERT_TRUE(none.k1_q16 == 0 && none.k2_q16 == 0 && none.chip_q32 == 0);
}

/// All of it at the ends of its range, under the sanitizers.
static void test_the_largest_numbers_fit(void)
{
    const cam_complex_t most = {.re = INT32_MAX, .im = INT32_MIN + 1};
    cam_drive_sums_t sums = {0};
    for (uint32_t k = 1; k <= 16u; k++) {
        cam_drive_add(&sums, k, most, most, (cam_complex_t){.re = INT16_MAX, .im = INT16_MAX});
    }
    const cam_drive_t by = cam_drive_solve(&sums, 1 << 18);
    TEST_ASSERT_TRUE(by.k1_q16 != 0 || by.k2_q16 != 0);
    (void)cam_drive_gain(16, 1 << 29, INT32_MAX, INT32_MAX);
}
