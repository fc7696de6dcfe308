// SPDX-License-Identifier: Apache-2.0
// One tick of a controller that has no table: it is off, moved by hand or in a fault behind that.
// It reads no table, and does not leave these states.
#include "world.h"

static bool is_of_a_bare_one(cam_state_t state)
{
    return state == cam_state_off || state == cam_state_manual || state == cam_state_fault;
}

void main(void)
{
    static const cam_state_t states[] = {cam_state_off, cam_state_manual, cam_state_fault};
    //@ loop unroll 3;
    for (uint32_t i = 0; i < 3; i++) {
        make_world();
        cfg->play.table = NULL;
        c.motion.state = states[i];
        c.motion.is_playing = false;
        cfg->play.swing.is_swung = false;
        cam_tick_isr(&c);
        if (!is_of_a_bare_one(c.motion.state)) {
            Frama_C_show_each_leaves("state without a table", c.motion.state);
        }
        if (c.motion.is_playing) {
            Frama_C_show_each_leaves("is_playing without a table", 1);
        }
    }
    Frama_C_show_each_end();
}
