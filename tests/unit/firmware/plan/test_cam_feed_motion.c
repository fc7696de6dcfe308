// SPDX-License-Identifier: Apache-2.0
// Override, hold and stop of the feed: accelerations, rates, rests on whole turns, the end of the
// part, and U at the height that Z has.
#define OWN_SET_UP
#include "cam_fix.h"
#include "cam_plan_inner.h" // cam_feed_motion_t, cam_feed_motion_begin_isr
#include "fixture_random.h"
#include "play_bench.h"

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
    engage();
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

/// A second stop does not move the end of the cut back to where Z came to rest: the tool would have
/// to leave the work in one tick.
static void test_stop_while_held_disengages_ahead_and_once(void)
{
    begin();
    until(cam_state_cutting);
    turns(9.0);
    hold(true);
    until(cam_state_holding);
    const double rest_nm = z_nm;
    turns(3.3);
    fixture_play_ask(&f, cam_request_stop);
    turns(0.1);
    const int64_t end_q32 = f.plan.disengage_at_q32;
    TEST_ASSERT_TRUE(end_q32 > f.angle.pos_q32);
    fixture_play_ask(&f, cam_request_stop);
    turns(0.1);
    TEST_ASSERT_EQUAL_INT64(end_q32, f.plan.disengage_at_q32);
    until(cam_state_disengaging);
    TEST_ASSERT_EQUAL_UINT32(0, cam_angle_of_pos(end_q32));
    TEST_ASSERT_TRUE(f.angle.pos_q32 - end_q32 < CAM_TURN_Q32 / 8);
    until(cam_state_ready);
    TEST_ASSERT_EQUAL_DOUBLE(rest_nm, z_nm);
}

/// Any order of overrides, holds, resumes: nothing but the time of the cut changes.
static void test_random_changes_always_end_at_the_last_height(void)
{
    fixture_random_t random = {.state = 1};
    for (int cut = 0; cut < 15 / fixture_rarer; cut++) {
        setUp();
        begin();
        for (int i = 0; i < 12 && f.want.state != cam_state_ready; i++) {
            ask((int32_t)fixture_random_range(&random, 0, 1500000));
            hold(fixture_random_range(&random, 0, 2) == 0);
            for (int64_t k = fixture_random_range(&random, 0, 5000);
                 k > 0 && f.want.state != cam_state_ready; k--) {
                tick();
            }
        }
        ask(1000000);
        cut_to_the_end();
    }
}

/// Wherever it comes before the end, a higher rate without room stays away, a hold is overtaken by
/// the end, and however little is left of the part after a rest, it is fed to the end.
static void test_changes_near_the_end_feed_the_whole_part(void)
{
    static const double at[] = {47.5, 48.0, 48.3, 48.6, 48.8, 48.9, 49.0, 49.2, 50.0, 50.9};
    static fixture_play_t kept;
    begin();
    until(cam_state_cutting);
    for (int i = 0, n = 0; i < 10; i++) {
        for (; n < (int)(at[i] * ticks_per_turn); n++) {
            tick();
        }
        kept = f;
        const double kept_nm[] = {z_nm, step_nm};
        for (int feed = 0; feed < 3; feed++) {
            hold(feed > 0);
            turns(feed > 0 ? 6.0 : 0.0);
            if (feed == 0 || f.want.state == cam_state_holding) {
                ask(feed == 1 ? 1000000 : 1500000);
            }
            cut_to_the_end();
            f = kept;
            z_nm = kept_nm[0];
            step_nm = kept_nm[1];
        }
    }
}

/// [turn / 2^32] master positions
#define TURNS(n) ((n)*CAM_TURN_Q32)

/// A feed that was held from its 4th turn on and rests at the 90th.
static const cam_feed_motion_t resting = {.is_held = true,
                                          .from_q32 = TURNS(3),
                                          .to_q32 = TURNS(4),
                                          .to_rate_q30 = 1 << 30,
                                          .brake_q32 = TURNS(70),
                                          .end_q32 = TURNS(90)};

/// What a feed makes of the configuration's rate a moment before a plan.
static cam_feed_motion_t requested(cam_feed_motion_t c, int64_t next_q32)
{
    cam_feed_motion_request_isr(&c, &f.config.play, next_q32 - 1000, next_q32);
    return c;
}

/// It rests where it is, and counts as ended: the tool leaves the work at once.
static void test_feed_of_which_nothing_is_left_ends_where_it_rests(void)
{
    const cam_play_config_t *cfg = &f.config.play;
    for (int32_t more = 0; more < 2; more++) {
        cam_feed_motion_t c = resting;
        c.fed_end_q32 = cfg->feed_q32 - cfg->ramp_q32 + more;
        c = requested(c, TURNS(100));
        TEST_ASSERT_FALSE(c.is_held);
        TEST_ASSERT_EQUAL_INT32(cfg->feed_rate_q30, c.requested_q30);
        TEST_ASSERT_INT64_WITHIN(1 << 20, TURNS(100), c.end_q32);
    }
    // At the 128th of the rate there is room for up and down, each in the 128th of a ramp.
    cam_feed_motion_t c = resting;
    c.fed_end_q32 = cfg->feed_q32 - cfg->ramp_q32 - cfg->ramp_q32 / 12000;
    c = requested(c, TURNS(100));
    TEST_ASSERT_TRUE(c.end_q32 - TURNS(100) > cfg->ramp_q32 / 64);
}

/// Before its first ring begins a ring-helix rests at once, for a hold and for a stop.
static void test_rings_that_have_not_begun_rest_at_once(void)
{
    cam_play_config_t *cfg = &f.config.play;
    cfg->rings.is_on = true;
    cfg->feed_rate_q30 = 0;
    for (int64_t early = 0; early < 14; early++) {
        const int64_t next_q32 = TURNS(10) - TURNS(early) / 4;
        cam_feed_motion_t c = {
            .from_q32 = TURNS(10), .end_q32 = TURNS(90), .requested_q30 = 1 << 30};
        const cam_feed_motion_t held = requested(c, next_q32);
        TEST_ASSERT_TRUE(held.is_held);
        TEST_ASSERT_EQUAL_INT64(next_q32, held.end_q32);
        cfg->feed_rate_q30 = 1 << 30;
        const cam_feed_motion_t resumed = requested(held, TURNS(11));
        cfg->feed_rate_q30 = 0;
        TEST_ASSERT_EQUAL_INT64(TURNS(11), resumed.from_q32);
        TEST_ASSERT_EQUAL_INT64(TURNS(11), resumed.to_q32);
        TEST_ASSERT_EQUAL_INT64(next_q32, cam_feed_motion_stop_isr(&c, cfg, next_q32));
        TEST_ASSERT_EQUAL_INT64(next_q32, c.end_q32);
    }
}

/// A stop ends a hold where it rests, or where the next turn begins if that is later.
static void test_stop_ends_a_hold(void)
{
    for (int64_t i = 0; i < 6; i++) { // of a helix and of rings
        const int64_t turn = 80 + i % 3 * 10;
        cam_feed_motion_t c = resting;
        f.config.play.rings.is_on = i >= 3;
        TEST_ASSERT_EQUAL_INT64(TURNS(turn > 90 ? turn : 90),
                                cam_feed_motion_stop_isr(&c, &f.config.play, TURNS(turn)));
        TEST_ASSERT_FALSE(c.is_held);
        TEST_ASSERT_EQUAL_INT64(TURNS(90), c.end_q32);
    }
}

/// Rings have no other rate than theirs: an override leaves their course as it is.
static void test_override_changes_no_rings(void)
{
    enum { one = 1 << 30 };
    cam_play_config_t *cfg = &f.config.play;
    cfg->rings.is_on = true;
    cfg->feed_rate_q30 = one / 2;
    cfg->ramp_q32 = cfg->feed_q32 = CAM_TURN_Q32;
    const cam_feed_motion_t before = {.from_q32 = TURNS(10),
                                      .to_q32 = TURNS(11),
                                      .brake_q32 = TURNS(70),
                                      .end_q32 = TURNS(71),
                                      .rate_q30 = one,
                                      .to_rate_q30 = one,
                                      .requested_q30 = one};
    for (int64_t turn = 5; turn < 80; turn += 5) {
        cam_feed_motion_t c = requested(before, TURNS(turn));
        TEST_ASSERT_EQUAL_INT32(one / 2, c.requested_q30); // and is not looked at again
        c.requested_q30 = one;
        TEST_ASSERT_EQUAL_MEMORY(&before, &c, sizeof c);
    }
}

enum { long_ramp = 30, stop_ramp = 2, per_turn = 16 };

/// A part of 200 turns whose feed rises over 30 turns, as with learning; a stop takes two.
static void set_long_ramp(cam_play_config_t *cfg)
{
    cfg->rings.is_on = false;
    cfg->feed_rate_q30 = 1 << 30;
    cfg->per_feed_rate_q24 = 1 << 24;
    cfg->feed_nm = 100000;
    cfg->ramp_q32 = TURNS(long_ramp);
    cfg->per_ramp_q31 = (uint32_t)((UINT64_C(1) << 31) / long_ramp);
    cfg->stop_ramp_q32 = TURNS(stop_ramp);
    cfg->per_stop_q31 = (uint32_t)((UINT64_C(1) << 31) / stop_ramp);
    cfg->feed_q32 = (200 + long_ramp) * CAM_TURN_Q32;
}

static void test_another_rate_waits_for_the_end_of_a_ramp(void)
{
    cam_play_config_t *cfg = &f.config.play;
    cam_feed_motion_t c = {0};
    set_long_ramp(cfg);
    cam_feed_motion_begin_isr(&c, cfg, TURNS(10));
    cfg->feed_rate_q30 /= 2;
    for (int64_t early = 1; early >= 0; early--) {
        cam_feed_motion_request_isr(&c, cfg, c.to_q32 - early, c.to_q32 + TURNS(1));
        TEST_ASSERT_EQUAL(early == 0, c.requested_q30 == cfg->feed_rate_q30);
    }
}

/// Wherever a stop comes, in the ramps or between them: what is commanded stays, Z rests within
/// three turns, and it never brakes more steeply than the ramp of a stop.
static void test_stop_ends_a_ramp_and_rests_within_three_turns(void)
{
    cam_play_config_t *cfg = &f.config.play;
    set_long_ramp(cfg);
    const double most_nm = 1.01 * cfg->feed_nm / stop_ramp / per_turn / per_turn + 2.0;
    for (int64_t turn = 11; turn < 200; turn++) {
        const int64_t next_q32 = turn * CAM_TURN_Q32;
        cam_feed_motion_t c = {0};
        cam_feed_motion_begin_isr(&c, cfg, 10 * CAM_TURN_Q32);
        const cam_feed_motion_t before = c;
        const int64_t end_q32 = cam_feed_motion_stop_isr(&c, cfg, next_q32);
        TEST_ASSERT_EQUAL_INT64(0, end_q32 % CAM_TURN_Q32);
        TEST_ASSERT_LESS_OR_EQUAL_INT64(next_q32 + 3 * CAM_TURN_Q32, end_q32);
        double last_nm = 0.0;
        double last_step_nm = 0.0;
        for (int64_t i = 10 * per_turn; i <= (turn + 5) * per_turn; i++) {
            const int64_t at_q32 = i * (CAM_TURN_Q32 / per_turn);
            const double fed_nm = cam_feed_motion_fed_nm_isr(&c, cfg, at_q32);
            const double change_nm = fed_nm - last_nm - last_step_nm;
            TEST_ASSERT_TRUE(i < 10 * per_turn + 2 || fabs(change_nm) <= most_nm);
            if (at_q32 <= next_q32) {
                TEST_ASSERT_INT32_WITHIN(1, cam_feed_motion_fed_nm_isr(&before, cfg, at_q32),
                                         (int32_t)fed_nm);
            }
            TEST_ASSERT_TRUE(at_q32 <= end_q32 || fed_nm - last_nm < 0.5);
            last_step_nm = fed_nm - last_nm;
            last_nm = fed_nm;
        }
    }
}
