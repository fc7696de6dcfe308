// SPDX-License-Identifier: Apache-2.0
// Exact instructions of every stage of the tick, by session: where a tick spends them.
#include "budget.h"
#include "budget_session.h"
#include "cam_tick.h"
#include "stages.h"
#include "unity.h"
#include <stdio.h>  // printf
#include <string.h> // memset

enum { least_ticks = 100000 };

/// Most that the sum of the stages may differ from the whole tick.
enum { sum_tolerance = 2 };

/// Of one session.
typedef struct {
    budget_spread_t stage[stage_n_marks];
    budget_spread_t tick[cam_n_states]; ///< sums of the stages, by the state after the tick
    stages_t longest;
    cam_state_t longest_state;
    uint32_t n_out_of_order; ///< ticks whose marks were not passed once each in order
    uint32_t most_off;       ///< [instructions] largest distance of sum and whole
} session_t;

static fixture_rig_t rig;
static session_t session;
static uint32_t n_ticks[cam_n_states]; ///< of all sessions

/// Called by Unity before the tests.
void suiteSetUp(void)
{
    printf("a mark takes %lu instructions\n", (unsigned long)stages_calibrate());
}

/// The interrupt by its address, so that it stays a function of its own.
static void (*volatile const interrupt)(void) = cam_isr;

/// The rig calls this instead of cam_isr().
static void counted(void)
{
    const stages_t n = stages_count(interrupt);
    const cam_state_t state = g_cam.motion.state;
    for (int stage = stage_sense; stage < stage_n_marks; stage++) {
        budget_spread_add(&session.stage[stage], n.of[stage]);
    }
    budget_spread_add(&session.tick[state], n.sum);
    n_ticks[state]++;
    if (n.sum > session.longest.sum) {
        session.longest = n;
        session.longest_state = state;
    }
    session.n_out_of_order += n.is_in_order ? 0u : 1u;
    const uint32_t off = n.sum > n.whole ? n.sum - n.whole : n.whole - n.sum;
    session.most_off = off > session.most_off ? off : session.most_off;
}

static void report(const char *name)
{
    budget_spread_print(name, "all", session.tick);
    for (int stage = stage_sense; stage < stage_n_marks; stage++) {
        const budget_spread_t *s = &session.stage[stage];
        printf("%-10s %-8s %4lu .. %4lu, mean %4lu instructions, %4lu in the longest tick\n", name,
               stages_name((stage_t)stage), (unsigned long)s->min, (unsigned long)s->max,
               (unsigned long)budget_spread_mean(s), (unsigned long)session.longest.of[stage]);
    }
    printf("%-10s longest tick: %lu instructions, %s; stages and whole differ by %lu at most\n",
           name, (unsigned long)session.longest.sum, cam_state_name(session.longest_state),
           (unsigned long)session.most_off);
}

static void expect_sums(const char *name)
{
    report(name);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(0, session.n_out_of_order, "ticks with marks out of order");
    TEST_ASSERT_LESS_OR_EQUAL_UINT32_MESSAGE(sum_tolerance, session.most_off,
                                             "stages and whole tick");
}

static void test_sum_of_the_stages_is_the_tick_in_each_session(void)
{
    static const struct {
        const char *name;
        bool (*play)(fixture_rig_t *rig, void (*isr)(void));
    } sessions[] = {
        {"uniform", budget_session_uniform},   {"modulated", budget_session_modulated},
        {"faults", budget_session_faults},     {"identify", budget_session_identify},
        {"rehearse", budget_session_rehearse}, {"hold", budget_session_hold},
        {"hand", budget_session_hand},
    };
    for (uint32_t i = 0; i < sizeof sessions / sizeof sessions[0]; i++) {
        memset(&session, 0, sizeof session);
        TEST_ASSERT_TRUE_MESSAGE(sessions[i].play(&rig, counted), sessions[i].name);
        expect_sums(sessions[i].name);
    }
}

/// Readings, force and its supervision: 480 instructions are 1 us of a core of 480 MHz that
/// executes one per cycle. The force leaves before its supervision.
static void test_force_leaves_soon_after_the_scale_is_latched(void)
{
    const fixture_part_t part = fixture_part_short();
    memset(&session, 0, sizeof session);
    TEST_ASSERT_TRUE(budget_session_force(&rig, counted, &part));
    report("force");
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(budget_sense_with_force, session.stage[stage_sense].max);
}

static void test_enough_ticks_in_all_states(void)
{
    uint32_t sum = 0;
    for (int state = 0; state < cam_n_states; state++) {
        TEST_ASSERT_GREATER_THAN_UINT32_MESSAGE(0, n_ticks[state],
                                                cam_state_name((cam_state_t)state));
        sum += n_ticks[state];
    }
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(least_ticks, sum);
}
