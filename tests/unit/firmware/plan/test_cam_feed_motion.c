// SPDX-License-Identifier: Apache-2.0
// Override and hold of the feed: accelerations, rates, rests on whole turns, the end of the part,
// and U at the height that Z has.
#include "cam_angle.h"
#include "fixture_play.h"
#include "fixture_random.h" // fixture_rarer
#include "unity.h"

static fixture_play_t f;
static fixture_part_t part;

enum { ticks_per_turn = 480, ramp_turns = 2, most_turns = 4000 };

/// [nm] per turn, 50 turns of the short part
enum { feed_nm = 20000 };

/// [nm / tick] of the programmed feed, and by how much it may change from tick to tick: the ramp's
/// acceleration of a whole plan at once, and whole nanometres
static const double pace_nm = (double)feed_nm / ticks_per_turn;
static const double most_change_nm =
    (double)feed_nm / ticks_per_turn / ticks_per_turn / ramp_turns * FIXTURE_PLAN_TICKS + 0.6;

static double z_nm, step_nm;

void setUp(void)
{
    part = fixture_part_short();
    part.feed_nm = feed_nm;
    fixture_play_init(&f, &part);
    f.params.feed_ramp_turns = ramp_turns;
    fixture_play_configure(&f);
    step_nm = 0.0;
}

static void ask(int32_t feed_ppm)
{
    f.params.feed_override_ppm = feed_ppm;
    fixture_play_configure(&f);
}

static void hold(bool is_held)
{
    fixture_play_configure(&f);
    f.config.play.feed_rate_q30 = is_held ? 0 : f.config.play.feed_rate_q30;
}

static void begin(void)
{
    TEST_ASSERT_TRUE(fixture_play_bring(&f, cam_state_engaging));
    TEST_ASSERT_TRUE(fixture_play_approach(&f));
    z_nm = (double)f.axis[hal_axis_z].pos_q10 / 1024.0;
}

/// One tick; Z never steps, never turns back and never leaves the part, and U is where the table
/// has it at the height that is played.
static void tick(void)
{
    fixture_play_tick(&f);
    const double now_nm = (double)f.axis[hal_axis_z].pos_q10 / 1024.0;
    TEST_ASSERT_DOUBLE_WITHIN(most_change_nm, step_nm, now_nm - z_nm);
    TEST_ASSERT_TRUE(now_nm - z_nm >= -0.01);
    TEST_ASSERT_TRUE(now_nm >= part.z_first_nm && now_nm <= part.z_last_nm);
    TEST_ASSERT_EQUAL_HEX32(0, f.want.faults);
    step_nm = now_nm - z_nm;
    z_nm = now_nm;
    if (f.want.state == cam_state_cutting || f.want.state == cam_state_holding) {
        TEST_ASSERT_DOUBLE_WITHIN(0.1, fixture_play_u_nm(&f, f.angle.pos_q32, f.want.z_nm),
                                  (double)f.want.u_set_q6 / 64.0);
        TEST_ASSERT_DOUBLE_WITHIN(2.0, now_nm, f.want.z_nm);
    }
}

static void turns(double n)
{
    for (int i = 0; i < (int)(n * ticks_per_turn); i++) {
        tick();
    }
}

static void until(cam_state_t state)
{
    for (int i = 0; i < most_turns * ticks_per_turn && f.want.state != state; i++) {
        tick();
    }
    TEST_ASSERT_EQUAL_INT(state, f.want.state);
}

static void cut_to_the_end(void)
{
    until(cam_state_ready);
    TEST_ASSERT_EQUAL_DOUBLE(part.z_last_nm, z_nm);
}

static void test_override_is_the_rate_of_the_feed(void)
{
    const int32_t ppm[] = {370000, 1500000, 10000, 1000000, 733333};
    begin();
    until(cam_state_cutting);
    turns(5.0);
    for (size_t i = 0; i < sizeof ppm / sizeof ppm[0]; i++) {
        ask(ppm[i]);
        turns(4.5);
        const double from_nm = z_nm;
        turns(2.0);
        TEST_ASSERT_DOUBLE_WITHIN(2.0, 2.0 * feed_nm * ppm[i] * 1e-6, z_nm - from_nm);
    }
    cut_to_the_end();
}

static void test_override_before_the_feed_holds_from_its_first_turn(void)
{
    ask(250000);
    begin();
    until(cam_state_cutting);
    double most_nm = 0.0;
    while (f.want.state == cam_state_cutting) {
        tick();
        most_nm = step_nm > most_nm ? step_nm : most_nm;
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.6, 0.25 * pace_nm, most_nm);
    cut_to_the_end();
}

static void test_untouched_feed_is_laid_as_it_was_before_overrides(void)
{
    begin();
    const int64_t fed_q32 = (int64_t)50 * CAM_TURN_Q32;
    TEST_ASSERT_EQUAL_INT64(f.plan.feed_at_q32 + fed_q32 + ramp_turns * CAM_TURN_Q32,
                            f.plan.disengage_at_q32);
    ask(1500000); // asked for and taken back in the first ramp
    until(cam_state_cutting);
    turns(0.3);
    ask(1000000);
    cut_to_the_end();
}

static void test_hold_rests_on_a_whole_turn_and_goes_on_from_one(void)
{
    begin();
    until(cam_state_cutting);
    turns(6.3);
    hold(true);
    until(cam_state_holding);
    TEST_ASSERT_EQUAL_UINT32(0, cam_angle_of_pos(f.plan.feed_motion.end_q32));
    TEST_ASSERT_TRUE(f.angle.pos_q32 - f.plan.feed_motion.end_q32 <
                     (FIXTURE_PLAN_TICKS + 1) * (int64_t)f.angle.speed_q32);
    turns(0.1);
    const double rest_nm = z_nm;
    turns(7.7);
    TEST_ASSERT_EQUAL_DOUBLE(rest_nm, z_nm);
    TEST_ASSERT_EQUAL_INT(cam_state_holding, f.want.state);
    hold(false);
    until(cam_state_cutting);
    TEST_ASSERT_EQUAL_UINT32(0, cam_angle_of_pos(f.plan.feed_motion.from_q32));
    cut_to_the_end();
}

static void test_hold_while_engaging_keeps_the_feed_from_beginning(void)
{
    begin();
    hold(true);
    until(cam_state_holding);
    turns(3.0);
    TEST_ASSERT_EQUAL_DOUBLE(part.z_first_nm, z_nm);
    hold(false);
    cut_to_the_end();
}

static void test_override_of_nothing_is_a_hold(void)
{
    ask(9999);
    begin();
    until(cam_state_holding);
    ask(10000);
    turns(10.0);
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, f.want.state);
    ask(1000000);
    cut_to_the_end();
}

static void test_stop_while_held_disengages(void)
{
    begin();
    until(cam_state_cutting);
    turns(9.0);
    hold(true);
    until(cam_state_holding);
    const double rest_nm = z_nm;
    fixture_play_ask(&f, cam_request_stop);
    until(cam_state_disengaging);
    TEST_ASSERT_EQUAL_UINT32(0, cam_angle_of_pos(f.plan.disengage_at_q32));
    until(cam_state_ready);
    TEST_ASSERT_EQUAL_DOUBLE(rest_nm, z_nm);
}

/// Who presses stop once more does not move the end of the cut to where Z came to rest, which lies
/// behind: the tool would be told to be off the work in one tick.
static void test_second_stop_while_held_leaves_the_end_ahead(void)
{
    begin();
    until(cam_state_cutting);
    turns(9.0);
    hold(true);
    until(cam_state_holding);
    turns(3.3);
    fixture_play_ask(&f, cam_request_stop);
    turns(0.1);
    const int64_t end_q32 = f.plan.disengage_at_q32;
    TEST_ASSERT_TRUE(end_q32 > f.angle.pos_q32);
    fixture_play_ask(&f, cam_request_stop);
    turns(0.1);
    TEST_ASSERT_EQUAL_INT64(end_q32, f.plan.disengage_at_q32);
    until(cam_state_disengaging);
    TEST_ASSERT_TRUE(f.angle.pos_q32 - end_q32 < CAM_TURN_Q32 / 8);
    until(cam_state_ready);
}

static void test_hold_within_the_last_ramp_is_overtaken_by_the_end(void)
{
    begin();
    until(cam_state_cutting);
    turns(50.9);
    hold(true);
    cut_to_the_end();
}

static void test_resume_near_the_end_creeps_there(void)
{
    begin();
    until(cam_state_cutting);
    turns(47.5); // rests behind 50 turns, with two turns left
    hold(true);
    until(cam_state_holding);
    TEST_ASSERT_TRUE(part.z_last_nm - z_nm < 2.5 * feed_nm);
    ask(1500000);
    cut_to_the_end();
}

/// A cut to go on from more than once: most of the way to the end of the part is always the same.
typedef struct {
    fixture_play_t f;
    double z_nm, step_nm;
} place_t;

static void keep(place_t *place)
{
    place->f = f;
    place->z_nm = z_nm;
    place->step_nm = step_nm;
}

static void go_back(const place_t *place)
{
    f = place->f;
    z_nm = place->z_nm;
    step_nm = place->step_nm;
}

static void test_rate_without_room_for_it_before_the_end_stays(void)
{
    static place_t place;
    begin();
    until(cam_state_cutting);
    turns(48.0);
    for (int tenth = 0; tenth < 30; tenth++) {
        keep(&place);
        ask(1500000);
        cut_to_the_end();
        go_back(&place);
        turns(0.1);
    }
}

/// Any order of overrides, holds, resumes: nothing but the time of the cut changes.
static void test_random_changes_always_end_at_the_last_height(void)
{
    uint32_t seed = 1;
    for (int cut = 0; cut < 40 / fixture_rarer; cut++) {
        setUp();
        begin();
        for (int i = 0; i < 12 && f.want.state != cam_state_ready; i++) {
            seed = seed * 1664525u + 1013904223u;
            const uint32_t what = seed >> 28;
            ask((int32_t)((seed >> 8) % 1500001u));
            hold(what < 5u);
            seed = seed * 1664525u + 1013904223u;
            for (uint32_t k = 0; k < (seed >> 18) % 5000u && f.want.state != cam_state_ready; k++) {
                tick();
            }
        }
        ask(1000000);
        cut_to_the_end();
    }
}

static void test_what_is_asked_again_changes_no_rate(void)
{
    begin();
    until(cam_state_cutting);
    const cam_feed_motion_t before = f.plan.feed_motion;
    cam_feed_motion_request_isr(&f.plan.feed_motion, &f.config.play, f.angle.pos_q32,
                                f.angle.pos_q32);
    TEST_ASSERT_EQUAL_MEMORY(&before, &f.plan.feed_motion, sizeof before);
}

/// However little of the part is left where the feed came to rest, it is fed to the end.
static void test_resume_feeds_the_least_that_is_left(void)
{
    static const double at[] = {48.0, 48.3, 48.6, 48.8, 48.9, 49.0, 49.2};
    static place_t place;
    begin();
    until(cam_state_cutting);
    for (int i = 0, n = 0; i < 7; i++) {
        for (; n < (int)(at[i] * ticks_per_turn); n++) {
            tick();
        }
        keep(&place);
        for (int feed = 0; feed < 2; feed++) {
            go_back(&place);
            hold(true);
            turns(6.0);
            if (f.want.state == cam_state_holding) {
                ask(feed == 0 ? 1000000 : 1500000);
            }
            cut_to_the_end();
        }
        go_back(&place);
    }
}
