// SPDX-License-Identifier: Apache-2.0
// Ends of a feed: one that goes on from a hold where nothing is left of the part, a rest that is
// asked for again, rings that rest before the first one has begun, and that know no override.
#include "cam_angle.h"
#include "cam_feed_motion.h"
#include "fixture_play.h"
#include "unity.h"
#include <math.h>

static fixture_play_t f;

void setUp(void)
{
    const fixture_part_t part = fixture_part_short();
    fixture_play_init(&f, &part);
}

/// It rests where it is, and counts as ended: the tool leaves the work at once.
static void test_feed_of_which_nothing_is_left_ends_where_it_rests(void)
{
    const cam_play_config_t *cfg = &f.config.play;
    const int64_t next_q32 = 100 * CAM_TURN_Q32;
    for (int32_t more = 0; more < 2; more++) {
        cam_feed_motion_t c = {.is_held = true,
                               .from_q32 = 3 * CAM_TURN_Q32,
                               .to_q32 = 4 * CAM_TURN_Q32,
                               .end_q32 = 90 * CAM_TURN_Q32,
                               .fed_end_q32 = cfg->feed_q32 - cfg->ramp_q32 + more};
        cam_feed_motion_request_isr(&c, cfg, next_q32 - 1000, next_q32);
        TEST_ASSERT_FALSE(c.is_held);
        TEST_ASSERT_EQUAL_INT32(cfg->feed_rate_q30, c.requested_q30);
        TEST_ASSERT_INT64_WITHIN(1 << 20, next_q32, c.end_q32);
    }
}

/// Whoever asks once more for the rest that a feed is in finds it there, as often as it is asked.
static void test_rest_that_is_asked_for_again_stays(void)
{
    f.config.play.feed_rate_q30 = 0;
    cam_feed_motion_t c = {.is_held = true,
                           .from_q32 = 3 * CAM_TURN_Q32,
                           .to_q32 = 4 * CAM_TURN_Q32,
                           .to_rate_q30 = 1 << 30,
                           .brake_q32 = 89 * CAM_TURN_Q32,
                           .end_q32 = 90 * CAM_TURN_Q32};
    const cam_feed_motion_t before = c;
    for (int64_t turn = 1; turn < 200; turn += 40) {
        cam_feed_motion_request_isr(&c, &f.config.play, turn * CAM_TURN_Q32 - 1000,
                                    turn * CAM_TURN_Q32);
        TEST_ASSERT_EQUAL_MEMORY(&before, &c, sizeof c);
    }
}

/// Before its first ring begins a ring-helix rests at once, for a hold and for a stop.
static void test_rings_that_have_not_begun_rest_at_once(void)
{
    cam_play_config_t *cfg = &f.config.play;
    cfg->rings.is_on = true;
    cfg->feed_rate_q30 = 0;
    for (int64_t early = 0; early < 14; early++) {
        const int64_t next_q32 = 10 * CAM_TURN_Q32 - early * CAM_TURN_Q32 / 4;
        cam_feed_motion_t c = {
            .from_q32 = 10 * CAM_TURN_Q32, .end_q32 = 90 * CAM_TURN_Q32, .requested_q30 = 1 << 30};
        cam_feed_motion_t stopped = c;
        cam_feed_motion_request_isr(&c, cfg, next_q32 - 1000, next_q32);
        TEST_ASSERT_TRUE(c.is_held);
        TEST_ASSERT_EQUAL_INT64(next_q32, c.end_q32);
        TEST_ASSERT_EQUAL_INT64(next_q32, cam_feed_motion_stop_isr(&stopped, cfg, next_q32));
        TEST_ASSERT_EQUAL_INT64(next_q32, stopped.end_q32);
    }
}

/// A stop ends a hold where it rests, or where the next turn begins if that is later.
static void test_stop_ends_a_hold(void)
{
    for (int64_t turn = 80; turn <= 100; turn += 10) {
        cam_feed_motion_t c = {.is_held = true, .end_q32 = 90 * CAM_TURN_Q32};
        const int64_t end_q32 = (turn > 90 ? turn : 90) * CAM_TURN_Q32;
        TEST_ASSERT_EQUAL_INT64(end_q32,
                                cam_feed_motion_stop_isr(&c, &f.config.play, turn * CAM_TURN_Q32));
        TEST_ASSERT_FALSE(c.is_held);
        TEST_ASSERT_EQUAL_INT64(90 * CAM_TURN_Q32, c.end_q32);
    }
}

/// Rings have no other rate than theirs: an override leaves their course as it is.
static void test_override_changes_no_rings(void)
{
    enum { one = 1 << 30, feed_nm = 20000 };
    static cam_play_config_t cfg;
    cfg.rings.is_on = true;
    cfg.feed_rate_q30 = one / 2;
    cfg.feed_nm = feed_nm;
    cfg.ramp_q32 = cfg.feed_q32 = CAM_TURN_Q32;
    const cam_feed_motion_t before = {.from_q32 = 10 * CAM_TURN_Q32,
                                      .to_q32 = 11 * CAM_TURN_Q32,
                                      .brake_q32 = 70 * CAM_TURN_Q32,
                                      .end_q32 = 71 * CAM_TURN_Q32,
                                      .rate_q30 = one,
                                      .to_rate_q30 = one,
                                      .requested_q30 = one};
    for (int64_t turn = 5; turn < 80; turn += 5) {
        cam_feed_motion_t c = before;
        cam_feed_motion_request_isr(&c, &cfg, turn * CAM_TURN_Q32, (turn + 1) * CAM_TURN_Q32);
        TEST_ASSERT_EQUAL_INT32(one / 2, c.requested_q30); // and is not looked at again
        TEST_ASSERT_EQUAL_INT64(before.from_q32, c.from_q32);
        TEST_ASSERT_EQUAL_INT64(before.to_q32, c.to_q32);
        TEST_ASSERT_EQUAL_INT64(before.end_q32, c.end_q32);
        TEST_ASSERT_EQUAL_INT32(one, c.to_rate_q30);
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
    cfg->ramp_q32 = long_ramp * CAM_TURN_Q32;
    cfg->per_ramp_q31 = (uint32_t)((UINT64_C(1) << 31) / long_ramp);
    cfg->stop_ramp_q32 = stop_ramp * CAM_TURN_Q32;
    cfg->per_stop_q31 = (uint32_t)((UINT64_C(1) << 31) / stop_ramp);
    cfg->feed_q32 = (200 + long_ramp) * CAM_TURN_Q32;
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
        double step_nm = 0.0;
        for (int64_t i = 10 * per_turn; i <= (turn + 5) * per_turn; i++) {
            const int64_t at_q32 = i * (CAM_TURN_Q32 / per_turn);
            const double z_nm = cam_feed_motion_fed_nm_isr(&c, cfg, at_q32);
            const double change_nm = z_nm - last_nm - step_nm;
            TEST_ASSERT_TRUE(i < 10 * per_turn + 2 || fabs(change_nm) <= most_nm);
            if (at_q32 <= next_q32) {
                TEST_ASSERT_INT32_WITHIN(1, cam_feed_motion_fed_nm_isr(&before, cfg, at_q32),
                                         (int32_t)z_nm);
            }
            TEST_ASSERT_TRUE(at_q32 <= end_q32 || z_nm - last_nm < 0.5);
            step_nm = z_nm - last_nm;
            last_nm = z_nm;
        }
    }
}
