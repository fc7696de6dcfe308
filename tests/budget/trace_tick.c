// SPDX-License-Identifier: Apache-2.0
// The image through which checks.cycles steps: every session twice, the first time to find its
// longest tick by the counter, the second time to stop before it.
#include "budget_count.h"
#include "budget_session.h"
#include "budget_trace.h"
#include "cam_tick.h"
#include <stdlib.h> // EXIT_SUCCESS

typedef struct {
    const char *session;
    uint32_t longest;      ///< number of its longest tick, from 1; 0: being looked for
    uint32_t instructions; ///< of that tick
    uint32_t n_ticks;
} search_t;

static fixture_rig_t rig;
static search_t search;
static uint32_t per_reading; ///< [instructions] what measuring costs

/// The interrupt by its address, so that it stays a function of its own.
static void (*volatile const interrupt)(void) = cam_isr;

/// The rig calls this instead of cam_isr().
static void counted(void)
{
    search.n_ticks++;
    if (search.n_ticks == search.longest) {
        budget_trace(search.session, search.instructions, interrupt);
    }
    const uint32_t from = budget_count();
    interrupt();
    const uint32_t n = budget_instructions(from, budget_count()) - per_reading;
    if (search.instructions < n) {
        search.instructions = n;
        search.longest = search.n_ticks;
    }
}

/// Twice the same: search the longest tick, then stop before it.
static bool trace(const char *session, bool (*run)(fixture_rig_t *, void (*)(void)))
{
    search = (search_t){.session = session};
    const bool is_found = run(&rig, counted);
    search.n_ticks = 0;
    return is_found && run(&rig, counted);
}

int main(void)
{
    budget_count_start();
    const uint32_t from = budget_count();
    per_reading = budget_instructions(from, budget_count());
    const bool is_done = trace("uniform table", budget_session_uniform) &&
                         trace("modulated table", budget_session_modulated) &&
                         trace("fault, modulated", budget_session_faults);
    return is_done ? EXIT_SUCCESS : EXIT_FAILURE;
}
