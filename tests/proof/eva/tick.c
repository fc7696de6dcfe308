// SPDX-License-Identifier: Apache-2.0
// One whole tick of any controller, with any values that the sensors can report. After it the
// controller must be within the same ranges. Tables with and without a feed profile, and with and
// without angles, are analysed separately, because each of them comes with parts of the plan.
#include "world.h"

/// Report a member that may be outside of its range: prove.py counts each report as an alarm.
#define VISIT(name, member, low, high)                                                             \
    if ((long long)(member) < (low) || (long long)(member) > (high)) {                             \
        Frama_C_show_each_leaves(name, member);                                                    \
    }
#include "ranges_walk.h"

void main(void)
{
    //@ loop unroll 4;
    for (uint32_t channels = 0; channels < 4; channels++) {
        make_world();
        if ((channels & 1u) == 0) {
            cfg->table.way.knots = NULL;
            cfg->table.has_stations = false; // cam_feed_profile_check()
        }
        if ((channels & 2u) == 0) {
            cfg->table.angle.knots = NULL;
            cfg->table.n_lobes = 0; // cam_lobes_check_patterns()
            cfg->play.swing.is_swung = false;
        }
        cam_tick_isr(&c);
        walk_state(&c);
    }
    Frama_C_show_each_end();
}
