// SPDX-License-Identifier: Apache-2.0
#include "lcn_index.h"

/// A calculated edge is reported 1/16 turn late, so that a real one has priority.
enum { late_part = 16 };

static void report(lcn_index_t *x, uint32_t counts)
{
    x->counts = counts;
    x->n++;
}

/// Report an edge that was not waited for at its calculated position, one turn after the last edge.
static void report_calculated(lcn_index_t *x, uint32_t raw, int32_t turn_counts)
{
    const int32_t since = (int32_t)(raw - x->counts); // wraps by design
    const int32_t most = turn_counts + turn_counts / late_part;
    if (since >= most) {
        report(x, x->counts + (uint32_t)turn_counts);
    } else if (since <= -most) {
        report(x, x->counts - (uint32_t)turn_counts);
    } else {
        // within the turn
    }
}

void lcn_index_step(lcn_index_t *x, const lcn_counters_t *now, int32_t turn_counts, bool is_off)
{
    const uint32_t latch = (uint32_t)now->raw - (uint32_t)now->counts;
    const bool is_edge = x->is_started && (latch != x->latch || (x->arms && !now->is_armed));
    x->is_started = true;
    x->latch = latch;
    x->is_known = (x->is_known || is_edge) && !is_off;
    if (is_edge) {
        report(x, latch);
    } else if (now->is_shared && x->is_known) {
        report_calculated(x, (uint32_t)now->raw, turn_counts);
    } else {
        // nothing to report
    }
    x->arms = !now->is_shared || !(x->is_known || is_off);
}
