// SPDX-License-Identifier: Apache-2.0
// What a turn shows: whether it counts, its harmonics by its ticks, its gaps, its feed, its phase.
// What a step compares with, and how much of an error it removes.
#include "cam_learning_inner.h"
#include "ilc_bench.h"

/// Play one turn. @return whether it counted
static bool counts(void)
{
    const uint32_t before = t.n_turns;
    play();
    return t.n_turns != before;
}

/// Each single exception is enough; an eighth of the amplitude is the least.
static void test_a_turn_that_is_not_like_the_others_does_not_count(void)
{
    static const struct {
        bool is_steady;
        int32_t scale_q30;
        cam_ilc_reason_t reason;
        uint32_t n_harmonics;
        bool counts;
    } rows[] = {
        {true, 1 << 30, cam_ilc_all, 4, true},        {false, 1 << 30, cam_ilc_all, 4, false},
        {true, 1 << 27, cam_ilc_all, 4, true},        {true, (1 << 27) - 1, cam_ilc_all, 4, false},
        {true, 1 << 30, cam_ilc_not_asked, 4, false}, {true, 1 << 30, cam_ilc_all, 0, false},
    };
    settle();
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        how.is_steady = rows[i].is_steady;
        how.scale_q30 = rows[i].scale_q30;
        s.reason = rows[i].reason;
        s.n_harmonics = rows[i].n_harmonics;
        TEST_ASSERT_EQUAL(rows[i].counts, counts());
    }
}

/// A turn that determines nothing is released at once, so that the slow side is free for the next.
static void test_a_turn_that_determines_nothing_is_released_at_once(void)
{
    settle();
    how.is_steady = false;
    n_polls = 1;
    play();
    const uint32_t bank = how.turn & 1u;
    TEST_ASSERT_EQUAL_UINT32(0, g.bin[bank * cam_turn_bins_n].n);
    TEST_ASSERT_EQUAL_UINT32((how.turn + 2u) | 1u << 24, g.cleared[bank]);
    n_polls = 40;
    how.is_steady = true;
    TEST_ASSERT_TRUE(counts());
}

/// Until the changes of the last step are in force for a whole turn, a turn determines nothing of
/// the next step.
static void test_a_turn_counts_when_the_drive_has_settled(void)
{
    settle();
    t.good_from = how.turn + 2u;
    TEST_ASSERT_FALSE(counts());
    TEST_ASSERT_TRUE(counts());
    t.good_from = 0xFFFFFFu; // turns are numbered modulo 2^24
    TEST_ASSERT_TRUE(counts());
}

/// Friction shows in the third harmonic; a step learns half of it.
static void test_friction_is_learned_by_the_gain(void)
{
    setUp();
    error_nm = 0.0;
    friction_nm = 300.0;
    for (int i = 0; i < 10 && t.drive.friction_q6 == 0; i++) {
        play();
    }
    TEST_ASSERT_INT32_WITHIN(64 * 6, 64 * 150, t.drive.friction_q6);
}

/// A speed that changes by a 128th runs up, and by a 1024th it ends a mean of the ripple.
static void test_a_turn_of_another_speed_than_the_last_does_not_count(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        settle();
        how.speed_q32 += sign * (usual_speed_q32 / 120);
        TEST_ASSERT_FALSE(counts());
        TEST_ASSERT_TRUE(counts());
        how.speed_q32 += sign * (usual_speed_q32 / 140);
        TEST_ASSERT_TRUE(counts());
        t.ripple.n = 3;
        how.speed_q32 += sign * (usual_speed_q32 / 1060);
        play();
        TEST_ASSERT_EQUAL_UINT32(3, t.ripple.n);
        how.speed_q32 += sign * (usual_speed_q32 / 1000);
        play();
        TEST_ASSERT_EQUAL_UINT32(0, t.ripple.n);
        const int32_t odd_q32 = how.speed_q32 / (128 - sign); // a 128th of the new speed
        how.speed_q32 += sign * (odd_q32 + 1);
        TEST_ASSERT_FALSE(counts());
        how.speed_q32 -= sign * (odd_q32 + 1);
        play();
        play();
        how.speed_q32 += sign * (odd_q32 - 100);
        TEST_ASSERT_TRUE(counts());
    }
}

static void test_slow_and_fast_turns_are_reported(void)
{
    settle();
    how.speed_q32 = 1 << 12;
    TEST_ASSERT_FALSE(counts());
    TEST_ASSERT_EQUAL_UINT8(cam_ilc_slow_turn, t.hindrance);
    how.is_steady = false; // as while the amplitude falls: the reason stays
    (void)counts();
    TEST_ASSERT_EQUAL_UINT8(cam_ilc_slow_turn, t.hindrance);
    how.is_steady = true;
    how.speed_q32 = (1 << 12) + 1;
    play();
    TEST_ASSERT_EQUAL_UINT8(cam_ilc_all, t.hindrance);
    TEST_ASSERT_TRUE(counts());
    n_ticks = 12; // 10 or 11 bins from one to the next, where 8 are the most
    TEST_ASSERT_FALSE(counts());
    TEST_ASSERT_EQUAL_UINT8(cam_ilc_fast_turn, t.hindrance);
}

/// A harmonic needs 24 ticks in its period, but for those of the oval, the first two, which do
/// with 9.
static void test_harmonics_are_as_many_as_the_ticks_resolve(void)
{
    static const struct {
        uint32_t ticks, harmonics;
    } cases[] = {{15, 0}, {16, 1}, {17, 1}, {18, 2}, {47, 2},
                 {48, 2}, {71, 2}, {72, 3}, {96, 4}, {400, 4}};
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        settle();
        n_ticks = cases[i].ticks;
        play();
        TEST_ASSERT_EQUAL_UINT8(cases[i].harmonics, t.n_orders);
    }
    settle();
    s.n_harmonics = 16;
    play();
    TEST_ASSERT_EQUAL_UINT8(16, t.n_orders);
}

/// Of few ticks the bins between them are filled by straight lines: the error stays what it is.
static void test_gaps_are_filled_by_straight_lines(void)
{
    settle();
    n_ticks = 32;
    play();
    TEST_ASSERT_UINT32_WITHIN(10, 707, t.error_nm);
    TEST_ASSERT_UINT32_WITHIN(64 * 1000, 64 * usual_set_nm, t.larger);
    TEST_ASSERT_EQUAL_INT32(0, t.true_q36);  // it shows no ripple
    for (int32_t gap = 8; gap <= 9; gap++) { // the last one across the begin of the turn
        static cam_turn_bin_t bins[cam_turn_bins_n];
        settle();
        for (int32_t i = 0; i < cam_turn_bins_n; i++) {
            const bool is_there = i % 4 == 3 && (i < 124 - gap || i == 127 - 4);
            bins[i] = is_there ? (cam_turn_bin_t){1, 5000, 0, 1} : (cam_turn_bin_t){0};
        }
        t.bin = bins;
        cam_ilc_update_begin(&t, &s, &how);
        TEST_ASSERT_EQUAL(gap == 8 ? cam_ilc_all : cam_ilc_fast_turn, t.hindrance);
        TEST_ASSERT_EQUAL_INT32(gap == 8 ? 5000 : 0, bins[0].u_nm);
    }
}

/// At half the amplitude the same error would be twice as large at the full one.
static void test_errors_are_those_at_full_amplitude(void)
{
    settle();
    how.scale_q30 = 1 << 29;
    play();
    TEST_ASSERT_UINT32_WITHIN(3, 1414, t.error_nm);
}

/// 78 / 64 times what the scale and the counts of the encoder make of a tick, over the root of the
/// ticks, and a nanometre.
static void test_the_floor_follows_from_the_resolution_of_scale_and_encoder(void)
{
    settle();
    play();
    TEST_ASSERT_EQUAL_UINT32(64, t.floor_q6);
    s.scale_nm = 100;
    play();
    TEST_ASSERT_EQUAL_UINT32(64 + 78 * 100 / 20, t.floor_q6);
    s.scale_nm = 0;
    s.count_urad = 1000; // of 100 um: 100 nm
    play();
    TEST_ASSERT_UINT32_WITHIN(4, 64 + 78 * 100 / 20, t.floor_q6);
    how.scale_q30 = 1 << 29;
    s.count_urad = 0;
    play();
    TEST_ASSERT_EQUAL_UINT32(128, t.floor_q6);
}

/// U stands where it moves by less than 4 nm from one bin to the next.
static void test_the_sense_is_that_of_a_motion_of_4_nm(void)
{
    static cam_turn_bin_t bins[cam_turn_bins_n];
    for (int32_t by_nm = -4; by_nm <= 4; by_nm++) {
        settle();
        for (int32_t i = 0; i < cam_turn_bins_n; i++) {
            bins[i] = (cam_turn_bin_t){.n = 4, .u_nm = 4 * by_nm * i};
        }
        t.bin = bins;
        t.blending = 0;
        how.turn++;
        cam_ilc_update_begin(&t, &s, &how);
        TEST_ASSERT_TRUE(t.is_counted);
        TEST_ASSERT_EQUAL_INT32(by_nm / 4 * (1 << 20), bins[64].n);
    }
}

/// The corrections may grow until their sum is the bound.
static void test_room_is_what_the_bound_leaves(void)
{
    settle();
    play();
    TEST_ASSERT_EQUAL_UINT32(64 * 30000, t.room_q6);
    t.correction.c_q6[5] = (cam_complex_t){.im = -64 * 13000};
    play();
    TEST_ASSERT_EQUAL_UINT32(64 * 17000, t.room_q6);
    s.most_q6 = 64 * 12000;
    play();
    TEST_ASSERT_EQUAL_UINT32(0, t.room_q6);
}

/// A cut at another speed than that of the rehearsal keeps what is in force, and goes on learning
/// when the speed comes back. Without a probe there is nothing to keep.
static void test_another_speed_freezes_a_cut(void)
{
    settle();
    how.state = cam_state_cutting;
    play_turns(2);
    how.speed_q32 = usual_speed_q32 / 100 * 103;
    play();
    TEST_ASSERT_EQUAL_UINT8(cam_ilc_cutting, t.phase);
    t.correction.is_probed = true;
    play();
    TEST_ASSERT_EQUAL_UINT8(cam_ilc_frozen, t.phase);
    TEST_ASSERT_FALSE(counts());
    how.speed_q32 = usual_speed_q32 / 100 * 101;
    play();
    TEST_ASSERT_EQUAL_UINT8(cam_ilc_cutting, t.phase);
    TEST_ASSERT_TRUE(counts());
}

/// Once two turns at the other speed agree, learning goes on there. The responses follow from the
/// constants of the drive: a first-order lag of a radian at the old speed.
static void test_two_turns_that_agree_end_the_freeze(void)
{
    settle();
    how.state = cam_state_cutting;
    play_turns(2);
    t.correction.is_probed = true;
    t.correction.gain[1] = (cam_complex_t){.re = 2048, .im = -2048}; // 1 / (1 + j)
    s.k1_q16 = (int32_t)lround(65536.0 * 4294967296.0 / (6.283185307 * usual_speed_q32));
    how.speed_q32 = usual_speed_q32 / 4 * 3;
    play(); // it changes too fast to count as even
    TEST_ASSERT_EQUAL_UINT8(cam_ilc_frozen, t.phase);
    play();
    TEST_ASSERT_EQUAL_UINT8(cam_ilc_frozen, t.phase);
    t.n_halved = 2;
    t.trusted = UINT32_MAX;
    play();
    TEST_ASSERT_EQUAL_UINT8(cam_ilc_cutting, t.phase);
    TEST_ASSERT_EQUAL_UINT8(0, t.n_halved); // the guards begin anew
    TEST_ASSERT_EQUAL_INT32(how.speed_q32, t.speed_q32);
    TEST_ASSERT_INT32_WITHIN(8, 2621, t.correction.gain[1].re); // 1 / (1 + 0.75 j)
    TEST_ASSERT_INT32_WITHIN(8, -1966, t.correction.gain[1].im);
}

/// A mode between two harmonics of the old speed leaves its response unknown at the new one: there
/// learning ends, and goes on elsewhere.
static void test_a_mode_ends_learning_where_it_lies(void)
{
    settle();
    how.state = cam_state_cutting;
    play_turns(2);
    t.correction.is_probed = true;
    for (int k = 1; k < 5; k++) {
        t.correction.gain[k] = (cam_complex_t){.re = (int16_t)(k < 3 ? 4096 : 2048)};
    }
    t.correction.gain[4].re = 2560; // a quarter more is no mode
    s.k1_q16 = 0;
    how.speed_q32 = usual_speed_q32 / 4 * 5; // harmonics 1.25, 2.5, 3.75, 5 of the old speed
    play_turns(3);
    TEST_ASSERT_EQUAL_UINT8(cam_ilc_cutting, t.phase);
    TEST_ASSERT_EQUAL_HEX32(1u << 2, t.correction.masked);
    TEST_ASSERT_INT32_WITHIN(8, 4096, t.correction.gain[1].re);
    TEST_ASSERT_INT32_WITHIN(8, 2560, t.correction.gain[4].re);
}

/// In the cut a feed that changes by more than a 64th lets the larger gain hold anew.
static void test_a_feed_that_changes_begins_the_steps_anew(void)
{
    settle();
    how.z_end_nm = 6400;
    how.state = cam_state_cutting;
    play_turns(4);
    TEST_ASSERT_EQUAL_UINT8(4, t.n_steps);
    how.z_begin_nm = -99;
    play();
    TEST_ASSERT_EQUAL_UINT8(5, t.n_steps);
    how.z_begin_nm = -99 - 105;
    play();
    TEST_ASSERT_EQUAL_UINT8(1, t.n_steps);
    TEST_ASSERT_EQUAL_INT32(6400, t.z_nm); // where the depth of the next turn is looked up
}

/// The correction turns with the shape that the operator turns, by 2^-12 turn at least.
static void test_the_phase_of_the_operator_turns_the_correction(void)
{
    settle();
    t.correction.c_q6[2] = (cam_complex_t){.re = 64000};
    how.phase_q32 = (1 << 20) - 1;
    play();
    TEST_ASSERT_EQUAL_INT32(64000, t.correction.c_q6[2].re);
    TEST_ASSERT_EQUAL_UINT32(0, t.phase_q32);
    how.phase_q32 = 1 << 29; // an eighth of a turn is a quarter of harmonic 2
    play();
    TEST_ASSERT_INT32_WITHIN(64, 0, t.correction.c_q6[2].re);
    TEST_ASSERT_INT32_WITHIN(64, -64000, t.correction.c_q6[2].im);
    TEST_ASSERT_EQUAL_UINT32(1u << 29, t.phase_q32);
    TEST_ASSERT_EQUAL_HEX8(cam_ilc_blend_correction, walked & cam_ilc_blend_correction);
    how.phase_q32 = 0;
    play();
    TEST_ASSERT_INT32_WITHIN(128, 64000, t.correction.c_q6[2].re);
}

/// At another speed nothing of the correction holds: a rehearsal there begins without it.
static void test_a_rehearsal_at_another_speed_forgets_the_correction(void)
{
    for (int percent = 101; percent <= 103; percent += 2) {
        settle();
        t.correction.is_probed = true;
        t.correction.c_q6[2] = (cam_complex_t){.re = 64000};
        how.state = cam_state_ready;
        play();
        how.state = cam_state_rehearsing;
        how.speed_q32 = usual_speed_q32 / 100 * percent;
        play_turns(2);
        TEST_ASSERT_EQUAL_UINT8(percent == 103 ? cam_ilc_settling : cam_ilc_shape, t.phase);
        TEST_ASSERT_EQUAL(percent == 101, t.correction.is_probed);
        TEST_ASSERT_EQUAL(percent == 103, t.correction.c_q6[2].re == 0);
        TEST_ASSERT_EQUAL_INT32(how.speed_q32, t.speed_q32);
        play();
        TEST_ASSERT_EQUAL_UINT8(percent == 103 ? cam_ilc_drive : cam_ilc_shape, t.phase);
    }
}

/// A 1024th of the first error in the rehearsal, a 16th in the cut, at least the resolution
/// of the scale.
static void test_guard_compares_above_a_part_of_the_first_error(void)
{
    t.phase = cam_ilc_shape;
    t.begun_nm = 16000;
    t.floor_q6 = 999;
    TEST_ASSERT_EQUAL_UINT32(1000, cam_ilc_update_guarded_q6(&t));
    t.floor_q6 = 1001;
    TEST_ASSERT_EQUAL_UINT32(1001, cam_ilc_update_guarded_q6(&t));
    t.phase = cam_ilc_cutting;
    TEST_ASSERT_EQUAL_UINT32(64000, cam_ilc_update_guarded_q6(&t));
    t.is_paused = true;
    t.last_square = 1;
    cam_ilc_update_restart_guards(&t);
    TEST_ASSERT_FALSE(t.is_paused);
    TEST_ASSERT_EQUAL_UINT64(UINT64_MAX, t.last_square);
}

static void test_a_speed_is_another_beyond_two_percent(void)
{
    t.speed_q32 = 1000000;
    TEST_ASSERT_FALSE(cam_ilc_update_is_other_speed(&t, 1020000));
    TEST_ASSERT_FALSE(cam_ilc_update_is_other_speed(&t, 980000));
    TEST_ASSERT_TRUE(cam_ilc_update_is_other_speed(&t, 1020001));
    TEST_ASSERT_TRUE(cam_ilc_update_is_other_speed(&t, 979999));
}

/// The learned harmonics hold most of the motion, which is more than 64 times the floor.
static void test_drive_is_determined_by_a_large_motion(void)
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

/// A turn of which harmonic 1 is next: U moves by 1000 nm, with an error in phase and half of that
/// in the mean.
static void begin_harmonic(cam_ilc_phase_t phase, double error_q6)
{
    static cam_turn_bin_t bins[cam_turn_bins_n];
    for (int i = 0; i < cam_turn_bins_n; i++) {
        const double at = TURN * (i + 0.5) / cam_turn_bins_n;
        bins[i].n = (int32_t)lround(0x1p20 * cos(at)); // the sense
        bins[i].u_nm = (int32_t)lround(1000.0 * cos(at));
        bins[i].error_q6 = (int32_t)lround(error_q6 * (0.5 + cos(at)));
    }
    t = (cam_ilc_t){.phase = (uint8_t)phase,
                    .bin = bins,
                    .k = 1,
                    .n_steps = 99,
                    .scale_q30 = 1 << 30,
                    .turn_speed_q32 = 1 << 22,
                    .largest = 64000,
                    .room_q6 = 1 << 24};
    t.correction.is_probed = true;
    t.correction.gain[0].re = t.correction.gain[1].re = 4096;
    t.correction.best_q6[0] = t.correction.best_q6[1] = UINT32_MAX;
}

/// What an eighth of the motion or more shares with the drive's constants it learns by half the
/// gain, the mean by three quarters; nothing in the cut where nothing is learned there.
static void test_large_harmonics_share_their_gain(void)
{
    static const struct {
        cam_ilc_phase_t phase;
        uint32_t k, largest;
        int32_t cut_gain_q16, learned_q6;
    } rows[] = {{cam_ilc_shape, 1, 505600, 8192, 16000}, {cam_ilc_shape, 1, 518400, 8192, 32000},
                {cam_ilc_shape, 0, 505600, 8192, 24000}, {cam_ilc_cutting, 1, 518400, 8192, 8000},
                {cam_ilc_shape, 1, 518400, 0, 32000},    {cam_ilc_shape, 0, 505600, 0, 24000},
                {cam_ilc_cutting, 1, 518400, 0, 0},      {cam_ilc_cutting, 0, 518400, 0, 0}};
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        begin_harmonic(rows[i].phase, 64000.0);
        t.k = (uint8_t)rows[i].k;
        t.largest = rows[i].largest;
        s.cut_gain_q16 = rows[i].cut_gain_q16;
        cam_ilc_update_harmonic(&t, &s);
        TEST_ASSERT_INT32_WITHIN(400, rows[i].learned_q6, t.correction.c_q6[rows[i].k].re);
    }
}

/// While the feed changes, and soon after, a large harmonic is left to the chip's force. As the
/// feed rises, the mean is the chip's as well.
static void test_a_change_of_the_feed_is_left_to_the_chip(void)
{
    static const struct {
        uint32_t k;
        int32_t feed_nm, learned_q6, chip_mean_q32;
    } rows[] = {
        {1, 1000, 16000, 0}, {1, 250000, 0, 0}, {0, 1000, 24000, 0}, {0, 250000, 0, 1610613}};
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        begin_harmonic(cam_ilc_cutting, 64000.0);
        t.k = (uint8_t)rows[i].k;
        t.n_steps = 0;
        t.feed_nm = rows[i].feed_nm;
        t.is_feed_rising = true;
        t.drive.chip_q32 = t.chip_most_q32 = 1 << 29;
        s.depth_nm = 1000000;
        cam_ilc_update_harmonic(&t, &s);
        TEST_ASSERT_INT32_WITHIN(400, rows[i].learned_q6, t.correction.c_q6[rows[i].k].re);
        TEST_ASSERT_INT32_WITHIN(4000, rows[i].chip_mean_q32, t.chip_mean_q32);
    }
}

/// U has to respond by a fifth; where it hardly moves, by less than a 128th, it shows friction.
static void test_drive_is_determined_by_what_u_responds_to(void)
{
    static const struct {
        double lag; ///< [rad] of which the response is 1 / (1 + j lag)
        uint32_t largest;
        bool is_drive, is_friction;
    } rows[] = {{4.8, 64000, true, false},
                {5.0, 64000, false, false},
                {1.0, 64000 * 127, true, false},
                {1.0, 64000 * 129, true, true}};
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        begin_harmonic(cam_ilc_shape, 64000.0);
        t.largest = rows[i].largest;
        s.k1_q16 = (int32_t)lround(rows[i].lag * 65536.0 * 1024.0 / TURN);
        cam_ilc_update_harmonic(&t, &s);
        TEST_ASSERT_EQUAL(rows[i].is_drive, t.sums.weight1 > 0.0);
        TEST_ASSERT_EQUAL(rows[i].is_friction, t.sums.weight_f > 0.0);
    }
}

/// In the cut the work changes: the best error that was seen counts for less from turn to turn,
/// unless the error grows, as when learning diverges.
static void test_best_error_ages_in_the_cut_alone(void)
{
    static const struct {
        cam_ilc_phase_t phase;
        uint32_t last_q6, best_q6;
    } cases[] = {{cam_ilc_shape, 16100, 16000},
                 {cam_ilc_shape, 16500, 16000},
                 {cam_ilc_cutting, 16500, 17001},
                 {cam_ilc_cutting, 16100, 16000}};
    for (int i = 0; i < 4; i++) {
        begin_harmonic(cases[i].phase, 16500.0);
        t.correction.best_q6[1] = 16000;
        t.correction.last_q6[1] = cases[i].last_q6;
        cam_ilc_update_harmonic(&t, &s);
        TEST_ASSERT_EQUAL_UINT32(cases[i].best_q6, t.correction.best_q6[1]);
        TEST_ASSERT_EQUAL_HEX8(cam_ilc_blend_correction, t.blending);
    }
}
