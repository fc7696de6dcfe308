// SPDX-License-Identifier: Apache-2.0
#include "cam_plan_inner.h"
#include "cam_fix.h" // CAM_TURN_Q32, cam_wrap_sub_i64

/// @return whether the mean speed of a turn agrees with that of the last one, if there is one
static bool is_agreeing(const cam_steady_t *s, uint32_t length_q24, uint32_t most_q16)
{
    const uint64_t now = (uint64_t)length_q24 * s->last_ticks;
    const uint64_t before = (uint64_t)s->last_q24 * s->ticks;
    const uint64_t off = now > before ? now - before : before - now;
    return off < (before >> 16) * most_q16;
}

/// Assigned one by one: an initialiser of the whole would call memset.
static void forget(cam_steady_t *s)
{
    s->ticks = 0;
    s->last_ticks = 0;
    s->n_turns = 0;
    s->n_agreeing = 0;
    s->waited_ticks = 0;
}

bool cam_steady_isr(cam_steady_t *s, const cam_play_config_t *cfg, cam_state_t state,
                    int64_t pos_q32, bool is_there)
{
    if (state != cam_state_engaging && state != cam_state_rehearsing) {
        forget(s);
        return false;
    }
    if (s->ticks == 0u) {
        s->from_q32 = pos_q32;
    }
    const int64_t length_q32 = cam_wrap_sub_i64(pos_q32, s->from_q32);
    if (length_q32 >= CAM_TURN_Q32) {
        const uint32_t length_q24 = (uint32_t)(uint64_t)(length_q32 >> 8);
        s->n_agreeing = is_agreeing(s, length_q24, cfg->agreeing_q16) ? s->n_agreeing + 1u : 0u;
        s->n_turns++;
        s->last_q24 = length_q24;
        s->last_ticks = s->ticks;
        s->from_q32 = pos_q32;
        s->ticks = 0;
    }
    if (is_there && s->n_agreeing >= cfg->steady_turns) {
        forget(s);
        return true;
    }
    s->ticks += (uint32_t)cfg->plan_ticks;
    s->waited_ticks += is_there ? (uint32_t)cfg->plan_ticks : 0u;
    return false;
}
