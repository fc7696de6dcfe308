// SPDX-License-Identifier: Apache-2.0
// Learning from rehearsal to rehearsal: what is kept, frozen, restored, read and set.
#include "learn_plant.h"
#include "unity.h"

static learn_plant_t p;

void setUp(void)
{
    const learn_case_t what = {.truth = {.bandwidth_hz = 300.0,
                                         .damping = 0.7,
                                         .delay_us = 75.0,
                                         .friction_mm_s2 = 5000.0,
                                         .quantum_um = 0.01},
                               .believed = {270.0, 0.77, 67.5, 0, 0, 0, 0, 0, 0.01, 0},
                               .amplitude_mm = {0.5, 0.0, 0.5},
                               .rpm = 3000.0,
                               .tick_hz = 20000,
                               .polls_per_tick_q4 = 16};
    learn_plant_init(&p, &what);
}

static cam_ilc_status_t status(void)
{
    return cam_ilc_status(&p.ilc, &p.setup, p.what.tick_hz);
}

/// test_cam_ilc_turns.c has its phases.
static void test_a_rehearsal_removes_the_error(void)
{
    learn_plant_turns(&p, cam_state_rehearsing, 40);
    TEST_ASSERT_TRUE(p.rms_um < 0.1);
    TEST_ASSERT_EQUAL_HEX32(0, status().masked);
    TEST_ASSERT_GREATER_THAN_UINT32(10000, status().begin_error_nm);
    TEST_ASSERT_UINT32_WITHIN(3000, 3000000, status().speed_mrpm);
}

static void test_a_fault_in_the_probe_leaves_no_probe(void)
{
    while (status().phase != cam_ilc_probing || p.ilc.n_steps < 2u) {
        learn_plant_turns(&p, cam_state_rehearsing, 1);
    }
    TEST_ASSERT_GREATER_THAN_UINT32(8000, status().correction_nm);
    learn_plant_turns(&p, cam_state_fault, 2);
    TEST_ASSERT_EQUAL_UINT32(0, status().correction_nm);
    TEST_ASSERT_EQUAL_INT16(0, p.learned.c[0]);
}

/// Let the slow side see another state, in which no turn was gathered.
static void enter(cam_ilc_t *t, cam_state_t state)
{
    static cam_turn_bins_t nothing;
    const cam_ilc_setup_t setup = {.reason = cam_ilc_all, .n_harmonics = 4};
    cam_ilc_poll(t, &setup, state, &nothing);
}

/// The correction and the constants of the smallest errors come back.
static void test_a_fault_brings_the_best_back(void)
{
    cam_ilc_t t;
    cam_ilc_init(&t);
    t.correction.c_q6[3] = (cam_complex_t){.re = 640, .im = -64};
    t.correction.kept[3].re_nm = 5;
    t.correction.kept[3].im_nm = 7;
    t.correction.best_q6[3] = 100;
    t.best_square = 1000;
    t.best_k1_q16 = 111;
    t.best_k2_q16 = 222;
    enter(&t, cam_state_fault);
    TEST_ASSERT_EQUAL_INT32(5 * 64, t.correction.c_q6[3].re);
    TEST_ASSERT_EQUAL_INT32(7 * 64, t.correction.c_q6[3].im);
    TEST_ASSERT_EQUAL_INT32(111, t.k1_q16);
    TEST_ASSERT_EQUAL_INT32(222, t.k2_q16);
    TEST_ASSERT_BITS_HIGH(cam_ilc_blend_drive | cam_ilc_blend_correction, t.blending);
}

/// The motion is in a harmonic that is not learned, so the effect of constants on it is not seen.
static void test_harmonics_without_the_motion_do_not_identify_the_drive(void)
{
    p.setup.reason = cam_ilc_not_asked;
    learn_plant_turns(&p, cam_state_rehearsing, 4);
    const double before_um = p.rms_um;
    setUp();
    p.what.amplitude_mm[1] = 0.0002;
    p.setup.n_harmonics = 1;
    learn_plant_turns(&p, cam_state_rehearsing, 44);
    TEST_ASSERT_EQUAL_INT32(0, status().k1_ns);
    TEST_ASSERT_EQUAL_INT32(0, status().k2_us2);
    TEST_ASSERT_TRUE(p.rms_um < 1.05 * before_um);
}

/// A shape that is nearly round where it is rehearsed shows no error; later the error may grow with
/// the shape.
static void test_a_shape_that_grows_from_nothing_is_learned_in_the_cut(void)
{
    learn_case_t what = p.what;
    what.truth.friction_mm_s2 = 0.0;
    what.believed = what.truth;
    learn_plant_init(&p, &what);
    p.scale = 0.0005;
    learn_plant_turns(&p, cam_state_rehearsing, 40);
    p.what.growth_per_turn = 0.005;
    learn_plant_turns(&p, cam_state_cutting, 200);
    TEST_ASSERT_TRUE(p.rms_um < 0.5);
    TEST_ASSERT_EQUAL_INT32(cam_ilc_all, status().reason);
}

/// 30 ticks per turn leave three of four bins empty; the oval's two harmonics are learned all the
/// same.
static void test_a_turn_of_few_ticks_teaches_the_oval(void)
{
    learn_case_t what = p.what;
    what.tick_hz = 1000;
    what.rpm = 2000.0;
    what.polls_per_tick_q4 = 160;
    what.truth.friction_mm_s2 = 0.0;
    learn_plant_init(&p, &what);
    learn_plant_turns(&p, cam_state_rehearsing, 3);
    const double before_um = p.rms_um;
    learn_plant_turns(&p, cam_state_rehearsing, 60);
    TEST_ASSERT_TRUE(before_um > 10.0);
    TEST_ASSERT_TRUE(p.rms_um < before_um / 10.0);
    TEST_ASSERT_EQUAL_INT32(cam_ilc_all, status().reason);
}

/// A spindle that turns evenly has no ripple, and a mean of four turns says so; an eccentricity
/// that is configured is then walked away from, in small steps.
static void test_an_even_spindle_shows_no_ripple(void)
{
    p.setup.ripple_turns = 4;
    p.setup.eccentricity.re = 20000; // [turn / 2^32]
    p.ilc.blending |= cam_ilc_blend_ripple;
    learn_plant_turns(&p, cam_state_rehearsing, 3);
    TEST_ASSERT_NOT_EQUAL_INT16(0, p.learned.dm[0]);
    TEST_ASSERT_EQUAL_UINT32(0, status().ripple_turns);
    learn_plant_turns(&p, cam_state_rehearsing, 24);
    TEST_ASSERT_EQUAL_UINT32(4, status().ripple_turns);
    TEST_ASSERT_LESS_THAN_UINT32(100, status().ripple_nturn);
    TEST_ASSERT_INT16_WITHIN(1, 0, p.learned.dm[0]);
    TEST_ASSERT_EQUAL_INT32(0, cam_ilc_harmonic(&p.ilc, 0).ripple.re);
    learn_plant_turns(&p, cam_state_cutting, 9);
    TEST_ASSERT_LESS_THAN_UINT32(100, status().ripple_nturn);
}

/// Each of the three constants is something that is forgotten, and without one nothing walks.
static void test_what_is_forgotten_is_walked_away_from(void)
{
    for (int i = 0; i < 4; i++) {
        p.ilc.speed_q32 = i == 1 ? 1 : 0;
        p.ilc.k1_q16 = i == 2 ? 1 : 0;
        p.ilc.k2_q16 = i == 3 ? 1 : 0;
        p.ilc.blending = 0;
        cam_ilc_forget(&p.ilc);
        TEST_ASSERT_EQUAL_HEX8(i == 0 ? 0 : cam_ilc_blend_drive | cam_ilc_blend_correction,
                               p.ilc.blending);
        TEST_ASSERT_EQUAL_INT32(0, p.ilc.speed_q32 | p.ilc.k1_q16 | p.ilc.k2_q16);
    }
}

/// A probe that was cut short is led back, too: what is in force is not yet what is known.
static void test_a_probe_cut_short_is_walked_away_from(void)
{
    cam_ilc_t t;
    cam_ilc_init(&t);
    t.state = cam_state_rehearsing;
    t.phase = cam_ilc_probing;
    t.correction.c_q6[2].re = 64 * 500;
    t.blending = 0;
    enter(&t, cam_state_ready);
    TEST_ASSERT_EQUAL_INT32(0, t.correction.c_q6[2].re);
    TEST_ASSERT_BITS_HIGH(cam_ilc_blend_correction, t.blending);
}
