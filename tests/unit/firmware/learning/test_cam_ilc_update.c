// SPDX-License-Identifier: Apache-2.0
// What a lesson compares with, and how much of an error a step removes.
#include "cam_ilc_update.h"
#include "unity.h"
#include <math.h> // cos, lround

static cam_ilc_t t;
static cam_ilc_setup_t s;

void setUp(void)
{
    t = (cam_ilc_t){.phase = cam_ilc_shape};
    s = (cam_ilc_setup_t){.gain_q16 = 32768, .cut_gain_q16 = 9830, .n_harmonics = 8};
}

/// A 1024th of what there was in the rehearsal, a 16th in the cut, not less than the scale tells.
static void test_guard_compares_above_a_part_of_the_first_error(void)
{
    t.begun_nm = 16000;
    t.floor_q6 = 999;
    TEST_ASSERT_EQUAL_UINT32(1000, cam_ilc_update_guarded_q6(&t));
    t.floor_q6 = 1001;
    TEST_ASSERT_EQUAL_UINT32(1001, cam_ilc_update_guarded_q6(&t));
    t.phase = cam_ilc_cutting;
    TEST_ASSERT_EQUAL_UINT32(64000, cam_ilc_update_guarded_q6(&t));
}

static void test_a_speed_is_another_beyond_two_percent(void)
{
    t.speed_q32 = 1000000;
    TEST_ASSERT_FALSE(cam_ilc_update_is_other_speed(&t, 1019999));
    TEST_ASSERT_FALSE(cam_ilc_update_is_other_speed(&t, 980001));
    TEST_ASSERT_TRUE(cam_ilc_update_is_other_speed(&t, 1020001));
    TEST_ASSERT_TRUE(cam_ilc_update_is_other_speed(&t, 979999));
}

static void test_phase_begins_with_no_steps(void)
{
    t.n_steps = 9;
    cam_ilc_update_phase(&t, cam_ilc_probing);
    TEST_ASSERT_EQUAL_UINT8(cam_ilc_probing, t.phase);
    TEST_ASSERT_EQUAL_UINT8(0, t.n_steps);
}

/// In the cut the larger gain holds for 16 steps; where nothing is learned there, none does.
static void test_gain_is_that_of_the_phase(void)
{
    TEST_ASSERT_EQUAL_INT32(32768, cam_ilc_update_gain_q16(&t, &s));
    t.n_steps = 16;
    TEST_ASSERT_EQUAL_INT32(32768, cam_ilc_update_gain_q16(&t, &s));
    t.phase = cam_ilc_cutting;
    TEST_ASSERT_EQUAL_INT32(9830, cam_ilc_update_gain_q16(&t, &s));
    t.n_steps = 15;
    TEST_ASSERT_EQUAL_INT32(32768, cam_ilc_update_gain_q16(&t, &s));
    s.cut_gain_q16 = 0;
    TEST_ASSERT_EQUAL_INT32(0, cam_ilc_update_gain_q16(&t, &s));
}

/// Its harmonics hold most of the motion, which is 64 times as large as what the scale can not
/// tell.
static void test_drive_is_told_by_a_large_motion(void)
{
    t.floor_q6 = 100;
    t.larger = 6464;
    TEST_ASSERT_TRUE(cam_ilc_update_is_for_drive(&t));
    t.larger = 6463;
    TEST_ASSERT_FALSE(cam_ilc_update_is_for_drive(&t));
    t.larger = 10000;
    t.set_square = -1;
    TEST_ASSERT_FALSE(cam_ilc_update_is_for_drive(&t));
}

/// U moves by 1000 nm in harmonic 1, and its error is 10 nm there.
static void test_a_harmonic_is_taken_at_its_size(void)
{
    static cam_turn_bin_t bins[cam_turn_bins_n];
    for (int i = 0; i < cam_turn_bins_n; i++) {
        const double at = 2.0 * 3.14159265358979323846 * i / cam_turn_bins_n;
        bins[i] = (cam_turn_bin_t){.n = 1};
        bins[i].u_nm = (int32_t)lround(1000.0 * cos(at));
        bins[i].error_q6 = (int32_t)lround(640.0 * cos(at));
    }
    t.bin = bins;
    t.k = 1;
    t.scale_q30 = 1 << 30;
    t.turn_speed_q32 = 1 << 22;
    t.phase = cam_ilc_drive;
    t.set_square = -500000;
    cam_ilc_update_harmonic(&t, &s);
    TEST_ASSERT_UINT32_WITHIN(200, 64000, t.larger);
    TEST_ASSERT_INT64_WITHIN(3000, 500000, t.set_square);
    TEST_ASSERT_UINT64_WITHIN(3000, 640 * 640 / 2, t.square);
    t.scale_q30 = 1 << 29; // at half the amplitude it would be twice that at the full one
    cam_ilc_update_harmonic(&t, &s);
    TEST_ASSERT_UINT32_WITHIN(400, 128000, t.larger);
}

/// What a large harmonic shares with the drive's constants it learns by half the gain.
static void test_large_harmonics_share_their_gain(void)
{
    static cam_turn_bin_t bins[cam_turn_bins_n];
    cam_complex_t learned[2];
    for (uint32_t i = 0; i < 2u; i++) {
        for (int k = 0; k < cam_turn_bins_n; k++) {
            const double at = 2.0 * 3.14159265358979323846 * (k + 0.5) / cam_turn_bins_n;
            bins[k].u_nm = (int32_t)lround(1000.0 * cos(at));
            bins[k].error_q6 = (int32_t)lround(64000.0 * cos(at));
        }
        t = (cam_ilc_t){.phase = cam_ilc_shape,
                        .bin = bins,
                        .k = 1,
                        .scale_q30 = 1 << 30,
                        .turn_speed_q32 = 1 << 22,
                        .largest = i == 0u ? 64000 : 64000 * 10,
                        .room_q6 = 1 << 24};
        t.correction.is_probed = true;
        t.correction.gain[1] = (cam_gain_t){.re_q12 = 4096};
        t.correction.best_q6[1] = UINT32_MAX;
        cam_ilc_update_harmonic(&t, &s);
        learned[i] = t.correction.c_q6[1];
    }
    TEST_ASSERT_INT32_WITHIN(400, 32000, learned[1].re);
    TEST_ASSERT_INT32_WITHIN(200, 16000, learned[0].re);
}

/// In the cut the work changes: the best error that was seen counts for less from turn to turn,
/// unless the error grows, as when learning diverges.
static void test_best_error_ages_in_the_cut_alone(void)
{
    static cam_turn_bin_t bins[cam_turn_bins_n];
    for (int k = 0; k < cam_turn_bins_n; k++) {
        const double at = 2.0 * 3.14159265358979323846 * (k + 0.5) / cam_turn_bins_n;
        bins[k] = (cam_turn_bin_t){.n = 1, .error_q6 = (int32_t)lround(16500.0 * cos(at))};
    }
    for (int i = 0; i < 3; i++) {
        t = (cam_ilc_t){.phase = i > 0 ? cam_ilc_cutting : cam_ilc_shape,
                        .bin = bins,
                        .k = 1,
                        .scale_q30 = 1 << 30,
                        .turn_speed_q32 = 1 << 22,
                        .largest = 64000,
                        .room_q6 = 1 << 24};
        t.correction.is_probed = true;
        t.correction.gain[1] = (cam_gain_t){.re_q12 = 4096};
        t.correction.best_q6[1] = 16000;
        t.correction.last_q6[1] = i == 1 ? 17000 : 16100;
        cam_ilc_update_harmonic(&t, &s);
        TEST_ASSERT_EQUAL_UINT32(i == 1 ? 17001 : 16000, t.correction.best_q6[1]);
    }
}
