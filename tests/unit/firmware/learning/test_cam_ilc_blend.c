// SPDX-License-Identifier: Apache-2.0
// From what is in force to what was learned: how large a step may be, when there is one, and when
// the drive has settled behind it.
#include "cam_learning.h"
#include "unity.h"

enum { usual_q8 = 1000 * 256 };

static cam_ilc_t t;
static cam_ilc_setup_t s;
static cam_learned_t in;

void setUp(void)
{
    cam_ilc_init(&t);
    s = (cam_ilc_setup_t){.reason = cam_ilc_all,
                          .n_harmonics = 4,
                          .ripple_turns = 4,
                          .angle_step_q23 = INT16_MAX,
                          .observer_step_q23 = INT16_MAX};
    in = (cam_learned_t){0};
    t.state = cam_state_rehearsing;
    t.blend_from_q8 = usual_q8;
}

static void walk(uint32_t at_q8)
{
    cam_ilc_blend(&t, &s, at_q8, &in);
}

/// A constant changes the command by no more than a step: 1 um in the rehearsal, 50 nm in the cut;
/// out of the work it is there at once.
static void test_constants_are_led_in_steps_of_the_command(void)
{
    static const struct {
        cam_state_t state;
        double most_nm;
    } cases[] = {{cam_state_rehearsing, 1000.0},
                 {cam_state_engaging, 50.0},
                 {cam_state_cutting, 50.0},
                 {cam_state_holding, 50.0},
                 {cam_state_disengaging, 50.0},
                 {cam_state_ready, 0.0},
                 {cam_state_off, 0.0}};
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        for (int32_t sign = -1; sign <= 1; sign += 2) {
            setUp();
            t.state = (uint8_t)cases[i].state;
            t.blending = cam_ilc_blend_drive;
            t.speed_nm = 2000.0;
            t.acceleration_nm = 30.0;
            t.drive.k1_q16 = sign * 40 * 65536;
            t.drive.k2_q16 = -sign * 700 * 65536;
            walk(usual_q8);
            if (cases[i].most_nm > 0.0) {
                const double k1 = sign * cases[i].most_nm / 2000.0;
                const double k2 = -sign * cases[i].most_nm / 30.0;
                TEST_ASSERT_DOUBLE_WITHIN(0.001, k1, in.k1_q16 / 65536.0);
                TEST_ASSERT_DOUBLE_WITHIN(0.01, k2, in.k2_q16 / 65536.0);
                TEST_ASSERT_EQUAL_HEX8(cam_ilc_blend_drive, t.blending);
            } else {
                TEST_ASSERT_EQUAL_INT32(t.drive.k1_q16, in.k1_q16);
                TEST_ASSERT_EQUAL_INT32(t.drive.k2_q16, in.k2_q16);
                TEST_ASSERT_EQUAL_HEX8(0, t.blending);
            }
        }
    }
}

/// The walk has ended when both constants are there, and they arrive exactly.
static void test_constants_arrive_exactly(void)
{
    t.blending = cam_ilc_blend_drive;
    t.speed_nm = 2000.0;
    t.acceleration_nm = 0x1p-8;
    t.drive.k1_q16 = 65536;
    t.drive.k2_q16 = -5;
    walk(usual_q8);
    TEST_ASSERT_EQUAL_INT32(-5, in.k2_q16);
    TEST_ASSERT_EQUAL_HEX8(cam_ilc_blend_drive, t.blending);
    for (int i = 0; i < 2; i++) {
        walk(usual_q8);
    }
    TEST_ASSERT_EQUAL_INT32(65536, in.k1_q16);
    TEST_ASSERT_EQUAL_HEX8(0, t.blending);
}

/// Out of the work U moves by time, and new gains would move its command at once.
static void test_constants_wait_out_of_the_work_while_u_moves(void)
{
    t.blending = cam_ilc_blend_drive;
    t.drive.k1_q16 = 1;
    s.is_u_moving = true;
    t.state = cam_state_ready;
    walk(usual_q8);
    TEST_ASSERT_EQUAL_INT32(0, in.k1_q16);
    TEST_ASSERT_EQUAL_HEX8(cam_ilc_blend_drive, t.blending);
    t.state = cam_state_cutting;
    walk(usual_q8);
    TEST_ASSERT_EQUAL_INT32(1, in.k1_q16);
}

/// A point of the correction moves by the same steps, and is there when all are.
static void test_correction_is_led_by_points(void)
{
    static const struct {
        cam_state_t state;
        int16_t most_nm;
    } cases[] = {{cam_state_rehearsing, 1000}, {cam_state_cutting, 50}, {cam_state_ready, 1500}};
    for (int i = 0; i < 3; i++) {
        setUp();
        t.state = (uint8_t)cases[i].state;
        t.blending = cam_ilc_blend_correction;
        t.correction.c_q6[0].re = 64 * 1500;
        walk(usual_q8);
        for (int k = 0; k <= cam_learned_points; k++) {
            TEST_ASSERT_EQUAL_INT16(cases[i].most_nm, in.c[k]);
        }
        TEST_ASSERT_EQUAL_HEX8(cases[i].most_nm < 1500 ? cam_ilc_blend_correction : 0, t.blending);
        TEST_ASSERT_EQUAL_UINT32(usual_q8 + 10u, t.blend_from_q8);
    }
}

/// 100 urad in the rehearsal, 10 in the cut; on a steep shape no farther than U can follow; and
/// where the spindle turns slowly, no farther than the observer can. What the encoder shows is
/// taken off before the observer; what of it is not the encoder's own is the true deviation.
static void test_ripple_is_led_by_points(void)
{
    static const struct {
        cam_state_t state;
        int16_t of_angle, of_observer, shown, is; ///< [2^-23 turn] steps, and the points they reach
    } cases[] = {
        {cam_state_rehearsing, INT16_MAX, INT16_MAX, 131, 131},
        {cam_state_cutting, INT16_MAX, INT16_MAX, 13, 13},
        {cam_state_holding, INT16_MAX, INT16_MAX, 13, 13},
        {cam_state_ready, INT16_MAX, INT16_MAX, 600, 400},
        {cam_state_rehearsing, 7, INT16_MAX, 7, 7},
        {cam_state_cutting, 7, INT16_MAX, 7, 7},
        {cam_state_ready, 7, INT16_MAX, 600, 400},
        {cam_state_rehearsing, INT16_MAX, 20, 20, 20},
        {cam_state_cutting, INT16_MAX, 20, 13, 13},
        {cam_state_ready, INT16_MAX, 20, 20, 20},
        {cam_state_engaging, INT16_MAX, 20, 20, 20},
        {cam_state_off, INT16_MAX, 20, 600, 400},
    };
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        setUp();
        s.angle_step_q23 = cases[i].of_angle;
        s.observer_step_q23 = cases[i].of_observer;
        t.state = (uint8_t)cases[i].state;
        t.blending = cam_ilc_blend_ripple;
        t.ripple.n_mean = 4;
        t.ripple.mean[0].re = 600;
        s.eccentricity.re = 200 * 512;
        walk(usual_q8);
        TEST_ASSERT_INT16_WITHIN(1, cases[i].shown, in.dm[0]);
        TEST_ASSERT_INT16_WITHIN(1, cases[i].is, in.d[0]);
        TEST_ASSERT_EQUAL_HEX8(cases[i].shown < 600 ? cam_ilc_blend_ripple : 0, t.blending);
        TEST_ASSERT_EQUAL_UINT32(usual_q8 + 20u, t.blend_from_q8);
    }
    setUp();
    t.state = cam_state_engaging; // U moves, as in the cut
    s.is_u_moving = true;
    t.blending = cam_ilc_blend_ripple;
    t.ripple.n_mean = 4;
    t.ripple.mean[0].re = 600;
    walk(usual_q8);
    TEST_ASSERT_EQUAL_INT16(13, in.dm[0]);
}

/// The walk has not ended while one of the two tables is not there.
static void test_both_tables_of_the_ripple_have_to_be_there(void)
{
    t.blending = cam_ilc_blend_ripple;
    t.ripple.n_mean = 4;
    s.eccentricity.re = -300 * 512; // shown is nothing, so that the spindle does what it hides
    walk(usual_q8);
    TEST_ASSERT_EQUAL_INT16(0, in.dm[0]);
    TEST_ASSERT_EQUAL_INT16(131, in.d[0]);
    TEST_ASSERT_EQUAL_HEX8(cam_ilc_blend_ripple, t.blending);
    walk(usual_q8 + 20u);
    walk(usual_q8 + 40u);
    TEST_ASSERT_EQUAL_INT16(300, in.d[0]);
    TEST_ASSERT_EQUAL_HEX8(0, t.blending);
    setUp();
    t.blending = cam_ilc_blend_ripple;
    t.ripple.n_mean = 4;
    t.ripple.mean[0].re = 300;
    s.eccentricity.re = 300 * 512; // all of it is the encoder's own
    walk(usual_q8);
    TEST_ASSERT_EQUAL_INT16(131, in.dm[0]);
    TEST_ASSERT_EQUAL_INT16(0, in.d[0]);
    TEST_ASSERT_EQUAL_HEX8(cam_ilc_blend_ripple, t.blending);
}

/// Where no mean was made, or none is asked for, only the configured eccentricity is taken off.
static void test_without_a_mean_the_eccentricity_is_what_is_known(void)
{
    for (int i = 0; i < 2; i++) {
        setUp();
        t.state = cam_state_ready;
        t.blending = cam_ilc_blend_ripple;
        t.ripple.n_mean = i == 0 ? 0 : 4;
        s.ripple_turns = i == 0 ? 4 : 0;
        t.ripple.mean[0].re = 900;
        t.ripple.mean[4].im = i == 0 ? 0 : 900;
        s.eccentricity.re = 300 * 512;
        walk(usual_q8);
        TEST_ASSERT_EQUAL_INT16(300, in.dm[0]);
        TEST_ASSERT_INT16_WITHIN(1, -300, in.dm[128]);
        TEST_ASSERT_EQUAL_INT16(0, in.d[0]);
    }
}

/// Points are made anew every tenth 256th of a turn at most; in off at once. The constants cost
/// nothing, and do not wait.
static void test_costly_steps_wait_for_their_place_in_the_turn(void)
{
    t.blending = cam_ilc_blend_correction | cam_ilc_blend_drive;
    t.correction.c_q6[0].re = 64;
    t.drive.k1_q16 = 1;
    TEST_ASSERT_TRUE(cam_ilc_is_blending(&t, usual_q8 - 1u));
    walk(usual_q8 - 1u);
    TEST_ASSERT_EQUAL_INT32(1, in.k1_q16);
    TEST_ASSERT_EQUAL_INT16(0, in.c[0]);
    TEST_ASSERT_EQUAL_HEX8(cam_ilc_blend_correction, t.blending);
    TEST_ASSERT_FALSE(cam_ilc_is_blending(&t, usual_q8 - 1u));
    TEST_ASSERT_TRUE(cam_ilc_is_blending(&t, usual_q8));
    t.state = cam_state_off;
    TEST_ASSERT_TRUE(cam_ilc_is_blending(&t, usual_q8 - 1u));
    static cam_turn_bin_t bin;
    t.bin = &bin; // a turn is being treated
    TEST_ASSERT_FALSE(cam_ilc_is_blending(&t, usual_q8));
    t.bin = NULL;
    walk(usual_q8 - 1u);
    TEST_ASSERT_EQUAL_INT16(1, in.c[0]);
    TEST_ASSERT_FALSE(cam_ilc_is_blending(&t, usual_q8));
}

/// The correction comes before the ripple: one set of points for each call.
static void test_one_set_of_points_is_led_at_a_time(void)
{
    t.state = cam_state_ready;
    t.blending = cam_ilc_blend_correction | cam_ilc_blend_ripple;
    t.ripple.n_mean = 1;
    t.ripple.mean[0].re = 100;
    walk(usual_q8);
    TEST_ASSERT_EQUAL_HEX8(cam_ilc_blend_ripple, t.blending);
    TEST_ASSERT_EQUAL_INT16(0, in.dm[0]);
    walk(usual_q8 + 10u);
    TEST_ASSERT_EQUAL_HEX8(0, t.blending);
    TEST_ASSERT_EQUAL_INT16(100, in.dm[0]);
}

/// In a rehearsal U has half a turn to settle before the first turn that is learned from; in the
/// cut, whose steps are small, that turn may begin with them.
static void test_turns_count_when_u_has_settled(void)
{
    static const struct {
        cam_state_t state;
        uint32_t part, behind;
    } cases[] = {
        {cam_state_rehearsing, 127, 1}, {cam_state_rehearsing, 128, 2},
        {cam_state_rehearsing, 0, 1},   {cam_state_cutting, 63, 0},
        {cam_state_cutting, 64, 1},     {cam_state_cutting, 255, 1},
    };
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        setUp();
        t.state = (uint8_t)cases[i].state;
        t.blending = cam_ilc_blend_drive;
        walk(usual_q8 + cases[i].part);
        TEST_ASSERT_EQUAL_UINT32(1000u + cases[i].behind, t.good_from);
    }
}
