// SPDX-License-Identifier: Apache-2.0
// The image through which checks.cycles steps: every session twice, the first time to find its
// longest tick by the counter, the second time to stop before it.
#include "budget_count.h"
#include "budget_strike.h"
#include "budget_trace.h"
#include "cam_tick.h"
#include "fixture_rig.h"
#include <stdlib.h> // EXIT_SUCCESS

enum { tick_hz = 20000, max_ticks = 60000 };

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

static bool set(cam_param_id_t id, int32_t value)
{
    return fixture_rig_set(&rig, id, value) == cam_ok;
}

static bool begin(const fixture_part_t *part)
{
    fixture_rig_init(&rig, part, tick_hz);
    rig.isr = counted;
    bool is_set = set(cam_param_following_limit_nm, 10000000);
    if (part->speed != NULL) {
        rig.lathe.ramp_rpm = 50.0;
        is_set = is_set && set(cam_param_spindle_acceleration_mrad_per_s2, 2000000000) &&
                 set(cam_param_spindle_mrpm, 2000000);
    }
    return is_set && fixture_rig_bring(&rig, cam_state_cutting);
}

static bool whole_cut(const fixture_part_t *part)
{
    return begin(part) && fixture_rig_until(&rig, cam_state_ready, max_ticks) < max_ticks;
}

static bool uniform_cut(void)
{
    const fixture_part_t part = fixture_part_short();
    return whole_cut(&part);
}

static bool modulated_cut(void)
{
    const fixture_part_t part = fixture_part_modulated();
    return whole_cut(&part);
}

static bool faults_in_the_cut(void)
{
    const fixture_part_t part = fixture_part_modulated();
    bool is_done = true;
    for (int fault = 0; fault < budget_n_strikes && is_done; fault++) {
        is_done = begin(&part);
        budget_strike(fault);
        is_done = is_done && fixture_rig_until(&rig, cam_state_fault, max_ticks) < max_ticks;
        fixture_rig_ticks(&rig, 500);
    }
    return is_done;
}

/// Twice the same: search the longest tick, then stop before it.
static bool trace(const char *session, bool (*run)(void))
{
    search = (search_t){.session = session};
    const bool is_found = run();
    search.n_ticks = 0;
    return is_found && run();
}

int main(void)
{
    budget_count_start();
    const uint32_t from = budget_count();
    per_reading = budget_instructions(from, budget_count());
    const bool is_done = trace("uniform table", uniform_cut) &&
                         trace("modulated table", modulated_cut) &&
                         trace("fault, modulated", faults_in_the_cut);
    return is_done ? EXIT_SUCCESS : EXIT_FAILURE;
}
