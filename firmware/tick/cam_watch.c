// SPDX-License-Identifier: Apache-2.0
#include "cam_watch.h"
#include "cam_seal.h" // cam_seal_word

uint32_t cam_watch_mend_isr(cam_watch_t *w, cam_axis_command_t *t, cam_motion_t *m,
                            const cam_tick_record_t *last)
{
    const bool is_off = m->state == cam_state_off;
    for (uint32_t i = (uint32_t)hal_axis_x; i <= (uint32_t)hal_axis_z; i++) {
        cam_axis_motion_t *axis = &m->axis[i];
        const int32_t pos_nm = (int32_t)(axis->pos_q10 >> 10);
        w->led_nm[i] = last != NULL ? last->out[i].pos_nm : w->led_nm[i];
        if (!is_off && (uint32_t)cam_watch_strayed_nm(w, t, i, pos_nm) > 1u) {
            if (cam_abs_i64(axis->vel_q10) < cam_abs_i64(t->vel_q10[i])) {
                t->vel_q10[i] = axis->vel_q10; // of two increments the slower one
            }
            axis->pos_q10 = (int64_t)w->led_nm[i] * 1024 + 512 + t->vel_q10[i];
            axis->vel_q10 = t->vel_q10[i];
        }
        t->vel_q10[i] = axis->vel_q10; // in off 0, and so in the tick that ends it
        w->led_nm[i] = (int32_t)(axis->pos_q10 >> 10);
    }
    return is_off ? 0u : CAM_FAULT_BIT(corrupt);
}

uint32_t cam_watch_mend_state_isr(const cam_watch_t *w, cam_motion_t *m, cam_state_t last)
{
    m->state = m->state == last ? last : w->state;
    return CAM_FAULT_BIT(corrupt);
}

void cam_watch_mend_home_isr(cam_watch_t *w, const cam_axis_command_t *t, cam_motion_t *m,
                             const cam_tick_record_t *last)
{
    const int32_t before_nm = cam_wrap_sub(t->u.nm, t->u.step_nm);
    if (cam_wrap_sub(before_nm, last->out[hal_axis_u].pos_nm) == m->u_home_nm) {
        w->u_home_nm = m->u_home_nm;
    } else {
        m->u_home_nm = w->u_home_nm;
    }
}

/// The sum of cam_seal_more(), with the loop written out by the compiler: two instructions a word.
CAM_STAGE static uint32_t seal_of(const cam_plan_t *plan)
{
    enum { n_words = sizeof *plan / sizeof(uint32_t) };
    _Static_assert(sizeof *plan % sizeof(uint32_t) == 0 && n_words <= 64, "whole words, no loop");
    const cam_seal_word_t *words = (const cam_seal_word_t *)plan; // MISRA D21
    uint32_t sum = 0;
#pragma GCC unroll 64
    for (uint32_t i = 0; i < (uint32_t)n_words; i++) {
        sum = cam_seal_word(sum, words[i]);
    }
    return sum;
}

CAM_STAGE uint32_t cam_watch_inspect_isr(cam_watch_t *w, cam_motion_t *m, const cam_plan_t *plan)
{
    const bool is_ended = plan->is_laid != m->is_playing && m->state != cam_state_fault;
    bool is_changed = is_ended || w->plan_seal != seal_of(plan);
    for (uint32_t i = (uint32_t)hal_axis_x; i <= (uint32_t)hal_axis_z; i++) {
        if (m->axis[i].pos_q10 >> 10 != w->led_nm[i]) {
            is_changed = true;
            m->axis[i].pos_q10 = (int64_t)w->led_nm[i] * 1024 + 512;
        }
    }
    return is_changed ? CAM_FAULT_BIT(corrupt) : 0u;
}

void cam_watch_plan_isr(cam_watch_t *w, const cam_motion_t *m, cam_plan_t *plan)
{
    plan->is_laid = m->is_playing;
    w->plan_seal = seal_of(plan);
    for (uint32_t i = (uint32_t)hal_axis_x; i <= (uint32_t)hal_axis_z; i++) {
        w->led_nm[i] = (int32_t)(m->axis[i].pos_q10 >> 10);
    }
    cam_watch_keep_isr(w, m);
}
