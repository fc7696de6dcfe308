// SPDX-License-Identifier: Apache-2.0
// What was learned, as others see and set it: numbers of the values, their ranges, their units.
#include "cam_learning_inner.h" // cam_ripple_most
#include "unity.h"
#include <string.h> // memcmp

static cam_ilc_t t;
static cam_ilc_setup_t s;

void setUp(void)
{
    cam_ilc_init(&t);
    s = (cam_ilc_setup_t){.reason = cam_ilc_all, .n_harmonics = 8};
}

/// The numbers are part of the CAN protocol, and each value has one of its own.
static void test_values_have_their_numbers(void)
{
    const struct {
        int32_t index;
        const void *word;
    } words[] = {{0, &t.speed_q32},
                 {1, &t.drive.k1_q16},
                 {2, &t.drive.k2_q16},
                 {3, &t.correction.masked},
                 {4, &t.phase_q32},
                 {5, &t.correction.c_q6[0].re},
                 {38, &t.correction.c_q6[16].im},
                 {39, &t.correction.gain[0].re},
                 {72, &t.correction.gain[16].im},
                 {73, &t.ripple.mean[0].re},
                 {104, &t.ripple.mean[15].im},
                 {105, &t.drive.friction_q6},
                 {106, &t.drive.chip_q32},
                 {107, &t.chip_mean_q32}};
    TEST_ASSERT_EQUAL_INT(108, cam_ilc_n_values);
    for (uint32_t i = 0; i < cam_ilc_n_values; i++) {
        TEST_ASSERT_TRUE(cam_ilc_set(&t, i, (int32_t)i + 1));
    }
    for (uint32_t i = 0; i < cam_ilc_n_values; i++) {
        TEST_ASSERT_EQUAL_INT32((int32_t)i + 1, cam_ilc_get(&t, i));
    }
    for (uint32_t i = 0; i < sizeof words / sizeof words[0]; i++) {
        TEST_ASSERT_EQUAL_INT32(words[i].index + 1, *(const int32_t *)words[i].word);
    }
}

/// The ends of each range are accepted; one beyond them is refused and leaves the old value.
static void test_each_value_has_its_range(void)
{
    static const struct {
        uint32_t index;
        int32_t least, most;
    } ranges[] = {
        {cam_ilc_value_speed, 0, 1 << 29},
        {cam_ilc_value_k1, -(1 << 30), 1 << 30},
        {cam_ilc_value_k2, -(1 << 30), 1 << 30},
        {cam_ilc_value_correction, -64 * 30000, 64 * 30000},
        {cam_ilc_value_gain - 1, -64 * 30000, 64 * 30000},
        {cam_ilc_value_gain, INT16_MIN, INT16_MAX},
        {cam_ilc_value_ripple - 1, INT16_MIN, INT16_MAX},
        {cam_ilc_value_ripple, -16383, 16383},
        {cam_ilc_value_friction - 1, -16383, 16383},
        {cam_ilc_value_friction, -64 * 30000, 64 * 30000},
    };
    for (uint32_t i = 0; i < sizeof ranges / sizeof ranges[0]; i++) {
        const uint32_t index = ranges[i].index;
        TEST_ASSERT_TRUE(cam_ilc_set(&t, index, ranges[i].least));
        TEST_ASSERT_FALSE(cam_ilc_set(&t, index, ranges[i].least - 1));
        TEST_ASSERT_EQUAL_INT32(ranges[i].least, cam_ilc_get(&t, index));
        TEST_ASSERT_TRUE(cam_ilc_set(&t, index, ranges[i].most));
        TEST_ASSERT_FALSE(cam_ilc_set(&t, index, ranges[i].most + 1));
        TEST_ASSERT_EQUAL_INT32(ranges[i].most, cam_ilc_get(&t, index));
    }
    TEST_ASSERT_TRUE(cam_ilc_set(&t, cam_ilc_value_phase, INT32_MIN));
    TEST_ASSERT_TRUE(cam_ilc_set(&t, cam_ilc_value_phase, INT32_MAX));
}

/// A harmonic has bit k of the masks, and bit 30 says that the answers of U are known.
static void test_masks_are_those_of_the_harmonics(void)
{
    const int32_t all = (1 << 17) - 1;
    TEST_ASSERT_TRUE(cam_ilc_set(&t, cam_ilc_value_masked, all | 1 << 30));
    TEST_ASSERT_EQUAL_HEX32(all, t.correction.masked);
    TEST_ASSERT_TRUE(t.correction.is_probed);
    TEST_ASSERT_FALSE(cam_ilc_set(&t, cam_ilc_value_masked, 1 << 17));
    TEST_ASSERT_EQUAL_HEX32(all | 1 << 30, cam_ilc_get(&t, cam_ilc_value_masked));
    TEST_ASSERT_TRUE(cam_ilc_set(&t, cam_ilc_value_masked, 1 << 16));
    TEST_ASSERT_FALSE(t.correction.is_probed);
    TEST_ASSERT_TRUE(cam_ilc_harmonic(&t, 16).is_masked);
    TEST_ASSERT_FALSE(cam_ilc_harmonic(&t, 15).is_masked);
    TEST_ASSERT_FALSE(cam_ilc_harmonic(&t, 17).is_masked);
}

/// A number that no value has changes nothing at all.
static void test_number_beyond_the_last_is_refused(void)
{
    t.blending = 0;
    const cam_ilc_t before = t;
    TEST_ASSERT_FALSE(cam_ilc_set(&t, cam_ilc_n_values, 1));
    TEST_ASSERT_FALSE(cam_ilc_set(&t, UINT32_MAX, 1));
    TEST_ASSERT_EQUAL_INT(0, memcmp(&before, &t, sizeof t));
    TEST_ASSERT_EQUAL_INT32(0, cam_ilc_get(&t, cam_ilc_n_values));
    TEST_ASSERT_EQUAL_INT32(0, cam_ilc_get(&t, UINT32_MAX));
}

/// What is set is walked to, and a ripple that is set is that of a mean.
static void test_what_is_set_is_walked_to(void)
{
    t.blending = 0;
    TEST_ASSERT_TRUE(cam_ilc_set(&t, cam_ilc_value_k1, 7));
    TEST_ASSERT_EQUAL_HEX8(cam_ilc_blend_all, t.blending);
    TEST_ASSERT_FALSE(cam_ilc_set(&t, cam_ilc_value_ripple, cam_ripple_most + 1));
    TEST_ASSERT_EQUAL_UINT32(0, t.ripple.n_mean);
    TEST_ASSERT_TRUE(cam_ilc_set(&t, cam_ilc_value_ripple, 7));
    TEST_ASSERT_EQUAL_UINT32(1, cam_ilc_status(&t, &s, 20000).ripple_turns);
    t.ripple.n_mean = 5;
    TEST_ASSERT_TRUE(cam_ilc_set(&t, cam_ilc_value_ripple, 8));
    TEST_ASSERT_EQUAL_UINT32(5, t.ripple.n_mean);
}

/// Ticks of 50 us: a tick is 50000 ns, its square 2500 us^2, and 2^32 / 400 per tick 3000 r/min.
static void test_status_is_reported_in_the_units_of_people(void)
{
    t.drive.k1_q16 = 3 << 15;
    t.drive.k2_q16 = -(5 << 16);
    t.speed_q32 = 10737418;
    t.correction.c_q6[3] = (cam_complex_t){.re = 300 * 64, .im = -400 * 64};
    t.correction.c_q6[0] = (cam_complex_t){.re = 64};
    t.ripple.mean[0].re = 300;
    t.ripple.mean[15].im = -400;
    t.drive.friction_q6 = -130 * 64;
    t.n_turns = 13;
    t.n_orders = 14;
    t.error_nm = 15;
    t.begun_nm = 16;
    const cam_ilc_status_t status = cam_ilc_status(&t, &s, 20000);
    TEST_ASSERT_EQUAL_INT32(75000, status.k1_ns);
    TEST_ASSERT_EQUAL_INT32(-12500, status.k2_us2);
    TEST_ASSERT_UINT32_WITHIN(1, 3000000, status.speed_mrpm);
    TEST_ASSERT_EQUAL_UINT32(501, status.correction_nm);
    TEST_ASSERT_UINT32_WITHIN(1, 83446, status.ripple_nturn); // 700 / 2^23 turn
    TEST_ASSERT_EQUAL_INT32(-130, status.friction_nm);
    TEST_ASSERT_EQUAL_UINT32(13, status.n_turns);
    TEST_ASSERT_EQUAL_UINT32(14, status.n_harmonics);
    TEST_ASSERT_EQUAL_UINT32(15, status.error_nm);
    TEST_ASSERT_EQUAL_UINT32(16, status.begin_error_nm);
}

/// What hinders the whole comes before what hinders a part, and where nothing is asked it is off.
static void test_phase_and_reason_are_reported(void)
{
    t.phase = cam_ilc_shape;
    TEST_ASSERT_EQUAL_INT(cam_ilc_shape, cam_ilc_status(&t, &s, 20000).phase);
    TEST_ASSERT_EQUAL_INT(cam_ilc_all, cam_ilc_status(&t, &s, 20000).reason);
    t.ripple.mean[3].im = -cam_ripple_most;
    TEST_ASSERT_EQUAL_INT(cam_ilc_rippled, cam_ilc_status(&t, &s, 20000).reason);
    t.ripple.mean[3].im = 0;
    t.hindrance = cam_ilc_fast_turn;
    TEST_ASSERT_EQUAL_INT(cam_ilc_fast_turn, cam_ilc_status(&t, &s, 20000).reason);
    s.reason = cam_ilc_lobes;
    TEST_ASSERT_EQUAL_INT(cam_ilc_shape, cam_ilc_status(&t, &s, 20000).phase);
    TEST_ASSERT_EQUAL_INT(cam_ilc_fast_turn, cam_ilc_status(&t, &s, 20000).reason);
    t.hindrance = cam_ilc_all;
    TEST_ASSERT_EQUAL_INT(cam_ilc_lobes, cam_ilc_status(&t, &s, 20000).reason);
    t.hindrance = cam_ilc_fast_turn;
    s.reason = cam_ilc_no_table;
    TEST_ASSERT_EQUAL_INT(cam_ilc_off, cam_ilc_status(&t, &s, 20000).phase);
    TEST_ASSERT_EQUAL_INT(cam_ilc_no_table, cam_ilc_status(&t, &s, 20000).reason);
}

/// The mean has a correction and no ripple; order k of the ripple is reported at harmonic k.
static void test_harmonic_is_reported(void)
{
    t.correction.c_q6[2] = (cam_complex_t){.re = 5, .im = 6};
    t.correction.gain[2] = (cam_complex_t){.re = 7, .im = 8};
    t.correction.best_q6[2] = 9;
    t.ripple.mean[1].re = 3;
    t.ripple.mean[1].im = -4;
    const cam_ilc_harmonic_t harmonic = cam_ilc_harmonic(&t, 2);
    TEST_ASSERT_EQUAL_INT32(5, harmonic.correction_q6.re);
    TEST_ASSERT_EQUAL_INT32(6, harmonic.correction_q6.im);
    TEST_ASSERT_EQUAL_INT16(7, harmonic.gain.re);
    TEST_ASSERT_EQUAL_INT16(8, harmonic.gain.im);
    TEST_ASSERT_EQUAL_UINT32(9, harmonic.best_q6);
    TEST_ASSERT_EQUAL_INT32(3 * 512, harmonic.ripple.re); // 2^-23 turn in 2^-32 turn
    TEST_ASSERT_EQUAL_INT32(-4 * 512, harmonic.ripple.im);
    TEST_ASSERT_EQUAL_INT32(0, cam_ilc_harmonic(&t, 0).ripple.re);
    TEST_ASSERT_EQUAL_INT32(0, cam_ilc_harmonic(&t, 1).ripple.re);
    t.correction.c_q6[16].re = 1;
    TEST_ASSERT_EQUAL_INT32(1, cam_ilc_harmonic(&t, 16).correction_q6.re);
    TEST_ASSERT_EQUAL_INT32(0, cam_ilc_harmonic(&t, 17).correction_q6.re);
}
