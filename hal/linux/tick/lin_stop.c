// SPDX-License-Identifier: Apache-2.0
#include "lin_tick.h"
#include "hal/hal.h" // hal_out_enable

/// Longest time for the retract, and for the drives to stop.
#define RETRACT_NS INT64_C(2000000000)
#define RELEASE_NS INT64_C(1000000000)

/// Signals within this time of the first count as one: closing a terminal sends two, one from the
/// terminal and one from its shell, within milliseconds.
#define SAME_NS INT64_C(300000000)

enum { least_release_ticks = 3 }; // so that each drive gets the command more than once

static void enter(lin_stop_t *s, lin_stop_phase_t phase, int64_t now_ns)
{
    s->phase = phase;
    s->since_ns = now_ns;
}

lin_stop_phase_t lin_stop_step(lin_stop_t *s, uint32_t n_signals, uint32_t outputs, bool is_at_rest,
                               int64_t now_ns)
{
    if (s->phase == lin_stop_run && n_signals > 0u) {
        enter(s, lin_stop_retract, now_ns);
    }
    if (s->phase == lin_stop_retract && now_ns - s->since_ns < SAME_NS) {
        s->n_signals = n_signals;
    }
    if (s->phase == lin_stop_retract &&
        ((outputs & hal_out_enable) == 0u || n_signals > s->n_signals ||
         now_ns - s->since_ns > RETRACT_NS)) {
        enter(s, lin_stop_release, now_ns);
    }
    if (s->phase == lin_stop_release) {
        s->n_ticks++;
        const bool is_done = is_at_rest && s->n_ticks > (uint32_t)least_release_ticks;
        if (is_done || now_ns - s->since_ns > RELEASE_NS) {
            enter(s, lin_stop_over, now_ns);
        }
    }
    return s->phase;
}
