// SPDX-License-Identifier: Apache-2.0
// Z along a ring-helix: the whole path against exact values, its ends, stop, and a measured Z.
#include "cam_angle.h"
#include "play_bench.h"
#include <math.h>

static const double turn_q32 = 4294967296.0;

/// 2500 r/min at 0.1 mm and 2000 mm/s2: the ramp is 0.0960 turns.
static void begin(void)
{
    part.is_ring_helix = true;
    fixture_play_init(&f, &part);
    TEST_ASSERT_TRUE(f.config.play.rings.is_on);
    engage();
}

/// @return [turn] since the path began
static double turns_of(int64_t pos_q32)
{
    return (double)(pos_q32 - f.plan.feed_at_q32) / turn_q32;
}

/// @return [nm] Z of the law in double
static double exact_nm(double turns)
{
    const double span_nm = (double)part.z_last_nm - part.z_first_nm;
    const double r = f.config.play.rings.ramp_q32 / turn_q32;
    const double length = 2.0 * ceil(span_nm / part.feed_nm) + 1.0;
    const double at = fmin(fmax(turns, 0.0), length);
    const double ring_nm = fmin(floor(at / 2.0) * part.feed_nm, span_nm);
    const double step_nm = fmin(part.feed_nm, span_nm - ring_nm);
    const double share = fmod(floor(at), 2.0) == 0.0 ? 0.0 : at - floor(at);
    const double near = fmin(share, 1.0 - share);
    const double fed = (near < r ? near * near / (2.0 * r) : near - r / 2.0) / (1.0 - r);
    return part.z_first_nm + ring_nm + step_nm * (share <= 0.5 ? fed : 1.0 - fed);
}

/// Between two plans Z moves linearly: off by the acceleration times (8 ticks)^2 / 8 at most,
/// 2000 mm/s2 * (0.4 ms)^2 / 8 = 40 nm, and two roundings.
static void test_whole_path_in_ticks_is_within_a_plan_of_the_exact_one(void)
{
    begin();
    double worst_nm = 0.0;
    while (f.want.state != cam_state_ready) {
        fixture_play_tick(&f);
        const double z_nm = (double)f.axis[hal_axis_z].pos_q10 / 1024.0;
        worst_nm = fmax(worst_nm, fabs(z_nm - exact_nm(turns_of(f.angle.pos_q32))));
        TEST_ASSERT_EQUAL_HEX32(0, f.want.faults);
    }
    TEST_ASSERT_TRUE(worst_nm < 42.0);
    TEST_ASSERT_TRUE(worst_nm > 30.0); // the bound is nearly reached, so it hides no error
    TEST_ASSERT_EQUAL_INT64((int64_t)part.z_last_nm * 1024, f.axis[hal_axis_z].pos_q10);
}

static void check_places(int64_t turns)
{
    begin();
    TEST_ASSERT_EQUAL_INT64(turns * CAM_TURN_Q32, f.plan.disengage_at_q32 - f.plan.feed_at_q32);
    for (double at = -0.5; at < (double)turns; at += 0.00713) {
        TEST_ASSERT_DOUBLE_WITHIN(0.6, exact_nm(at), z_at(at));
        TEST_ASSERT_EQUAL_INT(at < 0.0 ? cam_state_engaging : cam_state_cutting, f.want.state);
    }
    TEST_ASSERT_EQUAL_DOUBLE(part.z_last_nm, z_at((double)turns));
    TEST_ASSERT_EQUAL_INT(cam_state_disengaging, f.want.state);
}

static void test_every_place_is_exact_to_a_nanometre(void)
{
    check_places(21);
    part.feed_nm = 300001; // the last step is the rest of the height
    check_places(9);
    part.feed_nm = 1000000; // two rings, one turn between them
    check_places(3);
}

/// @return [turn] length of the path after a stop at `turns`
static double stopped_at(double turns)
{
    begin();
    while (turns_of(f.angle.pos_q32) < turns) {
        fixture_play_tick(&f);
    }
    fixture_play_do(&f, cam_request_stop);
    return (double)(f.plan.disengage_at_q32 - f.plan.feed_at_q32) / turn_q32;
}

static void test_stop_goes_on_to_the_end_of_a_ring(void)
{
    TEST_ASSERT_EQUAL_DOUBLE(1.0, stopped_at(0.3));   // in the first ring
    TEST_ASSERT_EQUAL_DOUBLE(3.0, stopped_at(1.3));   // in a turn of the helix: the ring behind it
    TEST_ASSERT_EQUAL_DOUBLE(3.0, stopped_at(2.3));   // in that ring
    TEST_ASSERT_EQUAL_DOUBLE(5.0, stopped_at(2.999)); // the turn behind it is planned already
    TEST_ASSERT_EQUAL_DOUBLE(21.0, stopped_at(20.5)); // in the last ring: as planned
    TEST_ASSERT_EQUAL_DOUBLE(3.0, stopped_at(1.3));
    while (f.want.state != cam_state_disengaging) {
        fixture_play_tick(&f);
    }
    TEST_ASSERT_EQUAL_INT64((int64_t)(part.z_first_nm + 100000) * 1024, f.axis[hal_axis_z].pos_q10);
    while (f.want.state != cam_state_ready) {
        fixture_play_tick(&f);
        TEST_ASSERT_EQUAL_INT64(0, f.axis[hal_axis_z].pos_q10 - f.before[hal_axis_z].pos_q10);
    }
}

static void test_stop_before_the_first_ring_leaves_z_where_it_is(void)
{
    TEST_ASSERT_TRUE(stopped_at(-5.0) <= 0.0);
    while (f.want.state != cam_state_ready) {
        fixture_play_tick(&f);
        TEST_ASSERT_EQUAL_INT64((int64_t)part.z_first_nm * 1024, f.axis[hal_axis_z].pos_q10);
    }
}

/// A held feed rests where the next ring begins and goes on from there, without a step, to the same
/// end.
static void test_hold_rests_before_a_ring_and_goes_on_from_it(void)
{
    begin();
    const int32_t rate_q30 = f.config.play.feed_rate_q30;
    while (turns_of(f.angle.pos_q32) < 6.3) {
        fixture_play_tick(&f);
    }
    f.config.play.feed_rate_q30 = 0;
    for (int i = 0; i < 100000 && f.want.state != cam_state_holding; i++) {
        fixture_play_tick(&f);
    }
    TEST_ASSERT_EQUAL_INT(cam_state_holding, f.want.state);
    fixture_play_ticks(&f, 100);
    const int64_t rest_q10 = f.axis[hal_axis_z].pos_q10;
    TEST_ASSERT_EQUAL_INT64((int64_t)(part.z_first_nm + 400000) * 1024, rest_q10);
    fixture_play_ticks(&f, 480 * 9 + 77);
    TEST_ASSERT_EQUAL_INT64(rest_q10, f.axis[hal_axis_z].pos_q10);
    f.config.play.feed_rate_q30 = rate_q30;
    double most_nm = 0.0;
    while (f.want.state != cam_state_ready) {
        fixture_play_tick(&f);
        const int64_t step_q10 = f.axis[hal_axis_z].pos_q10 - f.before[hal_axis_z].pos_q10;
        most_nm = fmax(most_nm, fabs((double)step_q10 / 1024.0));
        TEST_ASSERT_EQUAL_HEX32(0, f.want.faults);
    }
    TEST_ASSERT_TRUE(most_nm < 1.12 * part.feed_nm / 480.0); // the feed less its ramps
    TEST_ASSERT_EQUAL_INT64((int64_t)part.z_last_nm * 1024, f.axis[hal_axis_z].pos_q10);
}

/// Only a geared Z follows the path; a measured Z is led by others.
static void test_measured_z_knows_no_path(void)
{
    part.is_ring_helix = true;
    fixture_play_init(&f, &part);
    cut_at(123457);
    TEST_ASSERT_FALSE(f.config.play.rings.is_on);
    fixture_play_ticks(&f, 20000); // only stop ends the cut
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, f.want.state);
    TEST_ASSERT_EQUAL_INT32(123457, f.want.z_nm);
    fixture_play_do(&f, cam_request_stop);
    fixture_play_ticks(&f, 20000);
    TEST_ASSERT_EQUAL_INT(cam_state_ready, f.want.state);
}

/// The ramps of the path are made anew for another speed and feed.
static void test_ramps_fit_the_speed_in_force(void)
{
    part.is_ring_helix = true;
    fixture_play_init(&f, &part);
    const uint32_t at_2500 = f.config.play.rings.ramp_q32;
    f.params.spindle_mrpm = 1000000;
    fixture_play_configure(&f);
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.0140854, f.config.play.rings.ramp_q32 / turn_q32);
    f.params.spindle_mrpm = 2500000;
    fixture_play_configure(&f);
    TEST_ASSERT_EQUAL_UINT32(at_2500, f.config.play.rings.ramp_q32);
    f.params.feed_nm = 250000;
    fixture_play_configure(&f);
    TEST_ASSERT_GREATER_THAN_UINT32(at_2500, f.config.play.rings.ramp_q32);
    TEST_ASSERT_EQUAL_INT32(250000, f.config.play.rings.feed_nm);
    TEST_ASSERT_EQUAL_INT64(9 * CAM_TURN_Q32, f.config.play.feed_q32);
}
