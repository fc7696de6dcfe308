// SPDX-License-Identifier: Apache-2.0
#include "cam_switch.h"
#include "cam_angle.h" // cam_angle_of_pos
#include "cam_fix.h"   // cam_is_between
#include "cam_state.h" // cam_state_is_in_work
#include <stdbool.h>   // bool

/// Update the slowly changing conditions of one output.
static void refresh(cam_switches_t *s, const cam_switches_config_t *cfg, const cam_tick_record_t *r)
{
    const uint32_t i = s->next;
    const cam_switch_config_t *w = &cfg->each[i];
    const int32_t speed_q32 = r->angle.speed_q32;
    const cam_want_t *want = &r->want;
    const bool is_sense = w->sense == 0 || (w->sense > 0 ? speed_q32 > 0 : speed_q32 < 0);
    const bool is_height_in =
        w->is_anywhere || (cam_state_is_in_work(want->state) &&
                           cam_is_between(want->z_nm, w->z_low_nm, w->z_high_nm));
    const bool is_open = is_sense && is_height_in;
    s->next = i + 1u < cfg->n ? i + 1u : 0u;
    s->open = (s->open & ~(1u << i)) | (is_open ? 1u << i : 0u);
    const uint32_t lead_q32 = (uint32_t)(uint64_t)(((int64_t)speed_q32 * w->ahead_q16) >> 16);
    s->begin_q32[i] = lead_q32 * w->per_turn - w->from_q32;
}

/// @return bit i: the angle is in the window of output i
static uint32_t inside(const cam_switches_t *s, const cam_switches_config_t *cfg,
                       uint32_t theta_q32)
{
    uint32_t bits = 0;
    for (uint32_t i = cfg->n; i > 0u; i--) {
        const cam_switch_config_t *w = &cfg->each[i - 1u];
        const uint32_t phase_q32 = theta_q32 * w->per_turn + s->begin_q32[i - 1u];
        bits = bits * 2u + (phase_q32 < w->width_q32 ? 1u : 0u);
    }
    return bits;
}

/// Release outputs that have left the hysteresis of their last change, then change free ones.
/// Outputs no longer in use (after a change of parameters) go off.
static void settle(cam_switches_t *s, const cam_switches_config_t *cfg, uint32_t theta_q32,
                   uint32_t inside_bits)
{
    const uint32_t in_use = (1u << cfg->n) - 1u;
    s->on &= in_use;
    s->held &= in_use;
    for (uint32_t i = 0; i < cfg->n; i++) {
        const uint32_t bit = 1u << i;
        const uint32_t hysteresis_q32 = cfg->each[i].hysteresis_q32;
        const uint32_t away_q32 = theta_q32 - s->left_q32[i] + hysteresis_q32;
        if (away_q32 >= 2u * hysteresis_q32) {
            s->held &= ~bit;
        }
        if (((inside_bits ^ s->on) & ~s->held & bit) != 0u) {
            s->on ^= bit;
            s->held |= bit;
            s->left_q32[i] = theta_q32;
        }
    }
}

uint32_t cam_switches_step_isr(cam_switches_t *s, const cam_switches_config_t *cfg,
                               const cam_tick_record_t *r)
{
    if (cfg->n == 0u) {
        return 0;
    }
    const bool is_known =
        r->angle.is_synced && r->want.state != cam_state_off && r->want.state != cam_state_fault;
    if (!is_known) {
        s->on = 0;
        return 0;
    }
    const uint32_t theta_q32 = cam_angle_of_pos(r->angle.pos_q32);
    refresh(s, cfg, r);
    const uint32_t inside_bits = inside(s, cfg, theta_q32);
    if (((inside_bits ^ s->on) | s->held) != 0u) {
        settle(s, cfg, theta_q32, inside_bits);
    }
    return (s->on & s->open) * hal_out_switch_1;
}
