// SPDX-License-Identifier: Apache-2.0
// The step by which a cut rises: the polynomial itself, and what a drive with a lag makes of it.
#include "cam_motion.h"
#include "fixture_play.h" // fixture_play_smooth
#include "unity.h"
#include <math.h> // fabs, ldexp

enum { per_turn = 2000, length_turns = 4 };

static void test_smooth_everywhere_is_the_polynomial(void)
{
    const double bound = ldexp(1.0, -24);
    for (int64_t s = 0; s <= INT32_MAX; s += 1789) {
        const int32_t y = cam_envelope_smooth_q30((int32_t)s);
        const double want = fixture_play_smooth((double)s / 2147483648.0);
        TEST_ASSERT_TRUE(y >= 0 && y <= INT32_C(1) << 30);
        TEST_ASSERT_TRUE(fabs(y / 1073741824.0 - want) < bound);
    }
    TEST_ASSERT_EQUAL_INT32(0, cam_envelope_smooth_q30(0));
    TEST_ASSERT_EQUAL_INT32(INT32_C(1) << 30, cam_envelope_smooth_q30(INT32_MAX));
}

/// @return the step at a place in turns, as it is commanded to a drive of that lag
static double commanded(double turns, double lag_turns)
{
    const int64_t length_q32 = (int64_t)length_turns << 32;
    const uint32_t per_length_q31 = (UINT32_C(1) << 31) / length_turns;
    const int32_t y_q30 = cam_envelope_step_q30(
        (int64_t)ldexp(turns, 32), (int64_t)ldexp(lag_turns, 32), length_q32, per_length_q31);
    return ldexp((double)y_q30, -30);
}

/// A drive of two equal poles, each half the lag, moved on in small steps by the exact solution
/// for a command that stands from step to step. @return largest distance from the smooth step
static double missed_by_drive(double lag_turns)
{
    const double pole = exp(-2.0 / lag_turns / per_turn);
    double first = 0.0;
    double second = 0.0;
    double most = 0.0;
    for (int i = 0; i < (length_turns + 1) * per_turn; i++) {
        const double command = commanded((i + 0.5) / per_turn, lag_turns);
        second = pole * second + (1.0 - pole) * (pole * first + (1.0 - pole) * command);
        first = pole * first + (1.0 - pole) * command;
        const double s = fmin((i + 1.0) / per_turn / length_turns, 1.0);
        most = fmax(most, fabs(second - fixture_play_smooth(s)));
    }
    return most;
}

static void test_step_without_a_lag_is_the_smooth_step(void)
{
    for (int i = -per_turn; i <= (length_turns + 1) * per_turn; i++) {
        const double s = (double)i / per_turn / length_turns;
        const double want = s <= 0.0 ? 0.0 : s >= 1.0 ? 1.0 : fixture_play_smooth(s);
        TEST_ASSERT_DOUBLE_WITHIN(ldexp(1.0, -22), want, commanded((double)i / per_turn, 0.0));
    }
}

/// What the drive leaves of the step is the third derivative of it, 60 / length^3, and less by the
/// cube of the lag: far below what it would miss of the plain step, lag * 15 / (8 length).
static void test_drive_follows_the_step_it_is_commanded(void)
{
    TEST_ASSERT_TRUE(missed_by_drive(0.05) < 1.5e-4);
    TEST_ASSERT_TRUE(missed_by_drive(0.2) < 1.5e-4);
}

/// A lag of a sixteenth of the length is inverted as a whole, so its step begins in time; of a
/// longer lag the step begins earlier by what is beyond the sixteenth.
static void test_only_a_lag_beyond_a_sixteenth_is_read_ahead(void)
{
    const double sixteenth = length_turns / 16.0;
    for (double beyond = 0.0; beyond <= 1.0; beyond += 0.25) {
        TEST_ASSERT_TRUE(commanded(-beyond, sixteenth + beyond) == 0.0);
        TEST_ASSERT_TRUE(commanded(-beyond + 0.01, sixteenth + beyond) > 0.0);
    }
}
