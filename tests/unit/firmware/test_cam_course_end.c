// SPDX-License-Identifier: Apache-2.0
// A feed that goes on from a hold so near to the end of the part that nothing is left of it.
#include "cam_angle.h"
#include "cam_course.h"
#include "fixture_play.h"
#include "unity.h"

static fixture_play_t f;

void setUp(void)
{
    const fixture_part_t part = fixture_part_short();
    fixture_play_init(&f, &part);
}

void tearDown(void) {}

/// It rests where it is, and counts as ended: the tool leaves the work at once.
static void test_feed_of_which_nothing_is_left_ends_where_it_rests(void)
{
    const cam_play_config_t *cfg = &f.config.play;
    const int64_t next_q32 = 100 * CAM_TURN_Q32;
    for (int32_t more = 0; more < 2; more++) {
        cam_course_t c = {.is_held = true,
                          .from_q32 = 3 * CAM_TURN_Q32,
                          .to_q32 = 4 * CAM_TURN_Q32,
                          .end_q32 = 90 * CAM_TURN_Q32,
                          .fed_end_q32 = cfg->feed_q32 - cfg->ramp_q32 + more};
        cam_course_ask_isr(&c, cfg, next_q32 - 1000, next_q32);
        TEST_ASSERT_FALSE(c.is_held);
        TEST_ASSERT_EQUAL_INT32(cfg->feed_rate_q30, c.asked_q30);
        TEST_ASSERT_INT64_WITHIN(1 << 20, next_q32, c.end_q32);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_feed_of_which_nothing_is_left_ends_where_it_rests);
    return UNITY_END();
}
