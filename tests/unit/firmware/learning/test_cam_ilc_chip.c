// SPDX-License-Identifier: Apache-2.0
// The force of the chip: learned per feed, played with the present feed, in steps.
#include "cam_learning_inner.h"
#include "unity.h"
#include <math.h> // lround

static cam_ilc_t t;
static cam_turn_bins_t g;
static cam_learned_t in;

enum { speed_q32 = 10737418, half = 1 << 15 }; // 3000 r/min at 20 kHz; gain of a half

void setUp(void)
{
    cam_ilc_init(&t);
    g = (cam_turn_bins_t){0};
    in = (cam_learned_t){0};
    t.phase = (uint8_t)cam_ilc_cutting;
    t.correction.is_probed = true;
    t.correction.gain[0].re = 4096;
    t.feed_nm = 250000;
    t.turn_speed_q32 = speed_q32;
    t.largest = 64 * 100000;
}

static double share_of(int32_t q32)
{
    return q32 / 4294967296.0;
}

/// Z moves with a feed per turn.
static void feed(double feed_nm, cam_state_t state)
{
    g.z_vel_q10 = (int32_t)lround(feed_nm * 1024.0 * speed_q32 / 4294967296.0);
    cam_ilc_chip_follow(&t, state, &g);
}

/// There is a chip in a cut after a rehearsal, with a feed that does not fall.
static void test_chip_is_that_of_a_cut_after_a_rehearsal(void)
{
    TEST_ASSERT_TRUE(cam_ilc_chip_is_cut(&t));
    t.feed_nm = -1500; // Z moves either way
    TEST_ASSERT_TRUE(cam_ilc_chip_is_cut(&t));
    t.feed_nm = 1499;
    TEST_ASSERT_FALSE(cam_ilc_chip_is_cut(&t));
    t.feed_nm = 250000;
    t.is_feed_falling = true;
    TEST_ASSERT_FALSE(cam_ilc_chip_is_cut(&t));
    t.is_feed_falling = false;
    t.correction.is_probed = false;
    TEST_ASSERT_FALSE(cam_ilc_chip_is_cut(&t));
    t.correction.is_probed = true;
    t.phase = (uint8_t)cam_ilc_shape;
    TEST_ASSERT_FALSE(cam_ilc_chip_is_cut(&t));
}

/// A step adds half the error, by the feed of the turn over a quarter of a millimetre. The mean has
/// the sense of the rest and is no larger.
static void test_coefficients_are_learned_by_the_feed(void)
{
    t.feed_nm = 62500;
    cam_ilc_chip_step(&t, (int32_t)lround(0.002 * 4294967296.0), half);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.004, share_of(t.drive.chip_q32));
    cam_ilc_chip_step(&t, (int32_t)lround(-0.001 * 4294967296.0), half);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.002, share_of(t.drive.chip_q32));
    t.feed_nm = 250000;
    t.mean_nm = 50000;
    cam_ilc_chip_step_mean(&t, 64 * 300, 150000, half); // 0.0015 of the mean depth
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.00075, share_of(t.chip_mean_q32));
    t.correction.gain[0].re = 2048; // U responds with a half
    cam_ilc_chip_step_mean(&t, 64 * 300, 150000, half);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.00225, share_of(t.chip_mean_q32));
    cam_ilc_chip_step_mean(&t, -64 * 100, 150000, half); // from 0.002 on
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0015, share_of(t.chip_mean_q32));
}

/// Where U does not respond or the depth is unknown, the mean is not learned; no sum overflows.
static void test_mean_needs_a_response_and_a_depth(void)
{
    cam_ilc_chip_step_mean(&t, 6400, 0, half);
    t.correction.gain[0].re = 1000;
    cam_ilc_chip_step_mean(&t, 6400, 100000, half);
    TEST_ASSERT_EQUAL_INT32(0, t.chip_mean_q32);
    t.correction.gain[0].re = 1025;
    t.feed_nm = 1500;
    cam_ilc_chip_step_mean(&t, INT32_MIN, 1, 1 << 16);
    cam_ilc_chip_step(&t, INT32_MAX, 1 << 16);
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, t.chip_mean_q32);
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, t.drive.chip_q32);
    TEST_ASSERT_TRUE(t.is_limited);
}

/// What is played is in proportion to the feed, and 0 when nothing is cut. U's set-point has a mean
/// of 20 um, where the depth is 170 um.
static void test_what_is_played_follows_the_feed(void)
{
    t.drive.chip_q32 = (int32_t)lround(0.04 * 4294967296.0);
    t.chip_mean_q32 = (int32_t)lround(0.03 * 4294967296.0);
    t.mean_nm = 20000;
    static const double feeds_nm[] = {400000.0, 100000.0, -200000.0};
    for (int i = 0; i < 3; i++) {
        const double part = fabs(feeds_nm[i]) / 250000.0;
        feed(feeds_nm[i], cam_state_cutting);
        TEST_ASSERT_TRUE(cam_ilc_chip_is_due(&t));
        TEST_ASSERT_TRUE(cam_ilc_chip_blend(&t, 150000, 1 << 17, &in));
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.04 * part, share_of(in.chip_q32));
        const double mean_nm = (0.03 * 170000.0 - 0.04 * 20000.0) * part;
        TEST_ASSERT_DOUBLE_WITHIN(2.0, mean_nm, in.chip_q6 / 64.0);
        TEST_ASSERT_FALSE(cam_ilc_chip_is_due(&t));
    }
    feed(200000.0, cam_state_holding);
    TEST_ASSERT_TRUE(cam_ilc_chip_is_due(&t));
    TEST_ASSERT_TRUE(cam_ilc_chip_blend(&t, 150000, 1 << 17, &in));
    TEST_ASSERT_EQUAL_INT32(0, in.chip_q32);
    TEST_ASSERT_EQUAL_INT32(0, in.chip_q6);
}

/// A step moves the command by at most 50 nm in the cut, here with U moving by 0.1 mm.
static void test_what_is_played_moves_in_steps(void)
{
    t.drive.chip_q32 = (int32_t)lround(0.04 * 4294967296.0);
    t.chip_mean_q32 = (int32_t)lround(0.03 * 4294967296.0);
    feed(25000.0, cam_state_cutting);
    TEST_ASSERT_FALSE(cam_ilc_chip_blend(&t, 150000, 50, &in));
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 50.0, share_of(in.chip_q32) * 100000.0);
    TEST_ASSERT_EQUAL_INT32(50 * 64, in.chip_q6);
    TEST_ASSERT_TRUE(cam_ilc_chip_is_due(&t));
    int n = 1;
    while (!cam_ilc_chip_blend(&t, 150000, 50, &in)) {
        n++;
    }
    TEST_ASSERT_EQUAL_INT(8, n); // 450 nm of the mean, 400 nm of the share
}

/// It is bounded by the room in U's stroke, which is reported.
static void test_what_is_played_is_bounded(void)
{
    t.drive.chip_q32 = INT32_MIN;
    t.chip_mean_q32 = INT32_MIN;
    feed(2000000.0, cam_state_cutting);
    cam_ilc_fit(&t, 30001, 1000000 - 1); // U moves by 0.7 mm, the depth is 0.3 mm
    TEST_ASSERT_FALSE(t.is_limited);
    TEST_ASSERT_TRUE(cam_ilc_chip_blend(&t, 300000, 1 << 17, &in));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, -0.03, share_of(in.chip_q32));
    TEST_ASSERT_DOUBLE_WITHIN(1.0, -0.03 * 300000.0, in.chip_q6 / 64.0);
    TEST_ASSERT_TRUE(t.is_limited);
    feed(100.0, cam_state_cutting);
    cam_ilc_fit(&t, 1000000, 100000); // an eighth at most
    TEST_ASSERT_EQUAL_INT32(1 << 29, t.chip_most_q32);
}

/// A share of a 64th at a quarter of a millimetre, which a feed of 0.2 mm reaches with the reserve
/// of a quarter; an eighth of the depth at most.
static void test_room_is_wanted_for_a_feed_that_is_a_quarter_larger(void)
{
    t.feed_now_nm = 200000;
    for (int32_t sign = -1; sign <= 1; sign += 2) {
        t.drive.chip_q32 = sign * (1 << 26);
        TEST_ASSERT_EQUAL_INT64(10001, cam_ilc_wanted_nm(&t, 640000));
        t.drive.chip_q32 = sign > 0 ? 1 << 30 : -(1 << 30);
        TEST_ASSERT_EQUAL_INT64(80001, cam_ilc_wanted_nm(&t, 640000));
    }
}

/// Small changes of the feed are not followed, nor any while nothing is learned.
static void test_small_changes_of_the_feed_are_not_followed(void)
{
    t.drive.chip_q32 = 1 << 20;
    feed(100000.0, cam_state_cutting);
    (void)cam_ilc_chip_blend(&t, 0, 1 << 17, &in);
    feed(101200.0, cam_state_cutting);
    TEST_ASSERT_FALSE(cam_ilc_chip_is_due(&t));
    feed(101500.0, cam_state_cutting);
    TEST_ASSERT_TRUE(cam_ilc_chip_is_due(&t));
    t.drive.chip_q32 = 0;
    TEST_ASSERT_FALSE(cam_ilc_chip_is_due(&t));
}

/// @return whether layer 1 pauses after a turn with an error
static bool pauses_at(uint64_t error_q6)
{
    t.square = error_q6 * error_q6;
    cam_ilc_chip_follow_gap(&t);
    return t.is_paused;
}

/// An error that more than doubles pauses layer 1 until it is near what it was before.
static void test_layer_1_pauses_at_a_gap_in_the_material(void)
{
    t.last_square = UINT64_MAX; // as after a change of the feed
    t.floor_q6 = 64;
    TEST_ASSERT_FALSE(pauses_at(6400));
    TEST_ASSERT_FALSE(pauses_at(640));
    t.n_steps = 200;
    TEST_ASSERT_FALSE(pauses_at(1280)); // doubles
    TEST_ASSERT_EQUAL_UINT8(200, t.n_steps);
    TEST_ASSERT_FALSE(pauses_at(640));
    TEST_ASSERT_TRUE(pauses_at(1300));
    TEST_ASSERT_EQUAL_UINT8(0, t.n_steps);
    TEST_ASSERT_TRUE(t.best_square == UINT64_MAX);
    TEST_ASSERT_TRUE(pauses_at(64000)); // the gap is wider in the next turn
    TEST_ASSERT_TRUE(pauses_at(1400));
    TEST_ASSERT_FALSE(pauses_at(1200));
    TEST_ASSERT_FALSE(pauses_at(1400));
}

/// Noise below the floor and a rehearsal know no gaps.
static void test_noise_is_no_gap(void)
{
    t.last_square = 1;
    t.floor_q6 = 64;
    TEST_ASSERT_FALSE(pauses_at(64));
    t.phase = (uint8_t)cam_ilc_shape;
    t.last_square = 1;
    TEST_ASSERT_FALSE(pauses_at(64000));
}
