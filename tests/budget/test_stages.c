// SPDX-License-Identifier: Apache-2.0
// Exact instructions of every stage of the tick in a cut in which the firmware closes the loop of
// U: where a tick spends them. test_budget.c has whole ticks of all other sessions.
#include "budget.h"
#include "budget_session.h"
#include "cam_tick.h"
#include "stages.h"
#include "unity.h"
#include <stdio.h> // printf

/// Most that the sum of the stages may differ from the whole tick.
enum { sum_tolerance = 2, least_ticks = 10000 };

static fixture_rig_t rig;
static budget_spread_t spread[stage_n_marks];
static stages_t longest;
static uint32_t n_out_of_order; ///< ticks whose marks were not passed once each in order
static uint32_t most_off;       ///< [instructions] largest distance of sum and whole

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
    for (int stage = stage_sense; stage < stage_n_marks; stage++) {
        budget_spread_add(&spread[stage], n.of[stage]);
    }
    longest = n.sum > longest.sum ? n : longest;
    n_out_of_order += n.is_in_order ? 0u : 1u;
    const uint32_t off = n.sum > n.whole ? n.sum - n.whole : n.whole - n.sum;
    most_off = off > most_off ? off : most_off;
}

/// Readings, force and its supervision: 480 instructions are 1 us of a core of 480 MHz that
/// executes one per cycle. The force leaves before its supervision.
static void test_force_leaves_soon_after_the_scale_is_latched(void)
{
    const fixture_part_t part = fixture_part_short();
    TEST_ASSERT_TRUE(budget_session_force(&rig, counted, &part));
    for (int stage = stage_sense; stage < stage_n_marks; stage++) {
        const budget_spread_t *s = &spread[stage];
        printf("%-8s %4lu .. %4lu, mean %4lu instructions, %4lu in the longest tick of %lu\n",
               stages_name((stage_t)stage), (unsigned long)s->min, (unsigned long)s->max,
               (unsigned long)budget_spread_mean(s), (unsigned long)longest.of[stage],
               (unsigned long)longest.sum);
    }
    TEST_ASSERT_GREATER_THAN_UINT32(least_ticks, spread[stage_sense].n);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(0, n_out_of_order, "ticks with marks out of order");
    TEST_ASSERT_LESS_OR_EQUAL_UINT32_MESSAGE(sum_tolerance, most_off, "stages and whole tick");
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(budget_sense_with_force, spread[stage_sense].max);
}
