// SPDX-License-Identifier: Apache-2.0
#include "sim_live.h"
#include "sim_units.h" // SIM_UDEG_PER_TURN
#include <stdio.h>     // printf

/// Print the result of the finished part and mount the next blank.
static void end_part(sim_live_t *l)
{
    sim_session_t *s = &l->session;
    (void)printf("part %u: %.1f turns cut", l->n_parts, s->cut_turns);
    if (l->is_foreign_cut) {
        (void)printf(", not gauged: by another table than that of %s\n", s->table.name);
    } else if (s->work.n > 0u) {
        (void)printf(", form error max %.3f um, rms %.3f um\n", s->work.max_um,
                     sim_work_rms_um(&s->work));
    } else {
        (void)printf(", nothing of it on the part\n");
    }
    (void)fflush(stdout);
    sim_session_begin_pass(s);
}

void sim_live_gauge(sim_live_t *l)
{
    sim_session_t *s = &l->session;
    if (s->design.shape == sim_shape_lobes || s->table.n_passes > 1u) {
        return;
    }
    const bool is_in_cut = (hal_host.out.outputs & hal_out_in_cut) != 0u;
    const bool is_foreign = l->wire.played.table_crc32 != s->table.crc32;
    const sim_sample_t at = sim_lathe_sample(&l->port.lathe, l->port.time_s);
    s->phase_turn = l->wire.played.phase_udeg / SIM_UDEG_PER_TURN;
    if (is_in_cut && !l->was_in_cut) {
        l->n_parts++;
        l->is_foreign_cut = false;
    }
    l->is_foreign_cut = l->is_foreign_cut || is_foreign;
    sim_session_touch(s, &at, is_in_cut, 0.0);
    sim_lathe_bite(&l->port.lathe, sim_session_depth_mm(s));
    if (l->was_in_cut && !is_in_cut) {
        end_part(l);
    }
    l->was_in_cut = is_in_cut;
}
