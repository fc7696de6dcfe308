// SPDX-License-Identifier: Apache-2.0
#include "cam_motion.h"
#include "cam_fix.h" // cam_sat_i32

bool cam_excite_step_isr(cam_excite_t *e, const cam_excite_config_t *cfg, int32_t *offset_q6)
{
    const bool is_falling = e->n_left == 0u;
    if (is_falling && cfg->is_force) {
        *offset_q6 = 0;
        return true;
    }
    const bool is_at_goal =
        cam_move_profile_to_isr(&e->gain, &cfg->fade, is_falling ? 0 : cam_excite_full_q30);
    *offset_q6 = (int32_t)(((int64_t)cfg->wave[e->at] * cam_sat_i32(e->gain.pos_q10)) >> 24);
    e->at = e->at + 1u < cfg->n ? e->at + 1u : 0u;
    e->n_left -= is_falling ? 0u : 1u;
    return is_falling && is_at_goal;
}
