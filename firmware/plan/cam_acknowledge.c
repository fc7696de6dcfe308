// SPDX-License-Identifier: Apache-2.0
#include "cam_plan.h"

static void enter(cam_acknowledge_t *a, cam_acknowledge_phase_t phase)
{
    a->phase = phase;
    a->n_plans = 0;
}

/// Follow the button in the state off.
static void watch_press(cam_acknowledge_t *a, const cam_acknowledge_config_t *cfg, bool is_new)
{
    switch (a->phase) {
    case cam_acknowledge_needed:
        if (a->is_pressed) {
            a->n_plans = 0;
        } else if (a->n_plans >= cfg->least_plans) {
            enter(a, cam_acknowledge_armed);
        }
        break;
    case cam_acknowledge_armed:
        if (a->is_pressed) {
            enter(a, cam_acknowledge_pressed);
        }
        break;
    case cam_acknowledge_pressed:
        if (a->n_plans > cfg->most_plans) {
            enter(a, cam_acknowledge_needed);
        } else if (is_new) {
            enter(a,
                  a->n_plans >= cfg->least_plans ? cam_acknowledge_given : cam_acknowledge_needed);
        }
        break;
    case cam_acknowledge_given:
        if (a->n_plans >= cfg->good_plans) {
            enter(a, cam_acknowledge_needed);
        }
        break;
    case cam_acknowledge_used: // off again: the time for the next enable starts
        enter(a, cam_acknowledge_given);
        break;
    }
}

void cam_acknowledge_isr(cam_acknowledge_t *a, const cam_acknowledge_config_t *cfg,
                         const cam_tick_record_t *r, cam_motion_t *m)
{
    const bool is_pressed = (r->in.inputs & (uint32_t)hal_in_acknowledge) != 0u;
    a->n_other = is_pressed != a->is_pressed ? a->n_other + 1u : 0u;
    const bool is_new = a->n_other >= cfg->settle_plans; // the debounced level changes
    if (is_new) {
        a->is_pressed = is_pressed;
        a->n_other = 0;
    }
    a->n_plans++;
    const bool is_open = m->was_open || (r->in.inputs & (uint32_t)hal_in_estop) != 0u;
    m->was_open = false;
    if (is_open || m->state == cam_state_fault) {
        enter(a, cam_acknowledge_needed);
    } else if (m->state == cam_state_off) {
        watch_press(a, cfg, is_new);
    } else if (a->phase == cam_acknowledge_given) {
        enter(a, cam_acknowledge_used);
    } else { // no presses in motion
    }
    m->is_acknowledged = a->phase >= cam_acknowledge_given;
}

uint32_t cam_acknowledge_left(const cam_acknowledge_t *a, const cam_acknowledge_config_t *cfg)
{
    const bool is_left = a->phase == cam_acknowledge_given && a->n_plans < cfg->good_plans;
    return is_left ? cfg->good_plans - a->n_plans : 0u;
}
