// SPDX-License-Identifier: Apache-2.0
#include "lcn_index.h"

/// An edge that is due is reported this part of a turn late, so that a true one comes first.
enum { patience = 16 };

static void take(lcn_index_t *x, uint32_t place)
{
    x->counts = place;
    x->n++;
}

/// Report the edge that nobody waited for, where the last one says that it must have been.
static void take_due(lcn_index_t *x, uint32_t raw, int32_t turn_counts)
{
    const int32_t since = (int32_t)(raw - x->counts); // wraps by design
    const int32_t most = turn_counts + turn_counts / patience;
    if (since >= most) {
        take(x, x->counts + (uint32_t)turn_counts);
    } else if (since <= -most) {
        take(x, x->counts - (uint32_t)turn_counts);
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
        take(x, latch);
    } else if (now->is_shared && x->is_known) {
        take_due(x, (uint32_t)now->raw, turn_counts);
    } else {
        // nothing to report
    }
    x->arms = !now->is_shared || !(x->is_known || is_off);
}
