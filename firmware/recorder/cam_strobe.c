// SPDX-License-Identifier: Apache-2.0
#include "cam_recorder.h"
#include "cam_fix.h" // cam_wrap_sub
#include <stddef.h>  // NULL

_Static_assert((cam_strobe_capacity & (cam_strobe_capacity - 1)) == 0, "index by mask");

uint32_t cam_strobe_least(uint32_t tick_hz)
{
    return (tick_hz + (uint32_t)cam_strobe_hz - 1u) / (uint32_t)cam_strobe_hz;
}

void cam_strobe_subscribe(cam_strobe_t *s, uint32_t every, uint32_t tick)
{
    if (every != s->every) {
        s->every = every;
        s->next_tick = tick + 1u;
        s->number = 0;
        s->n_out = s->n_in;
    }
    s->renewed_tick = tick;
}

static void enqueue(cam_strobe_t *s, const cam_tick_record_t *r)
{
    if (s->n_in - s->n_out == (uint32_t)cam_strobe_capacity) {
        s->n_lost++;
        return;
    }
    s->queue[s->n_in % (uint32_t)cam_strobe_capacity] = (cam_strobe_sample_t){
        .number = s->number,
        .pos_q16 = (uint32_t)((uint64_t)r->angle.pos_q32 >> 16),
        .following_nm = cam_wrap_sub(r->in.actual_nm[hal_axis_u], r->want.u_due_q6 >> 6),
        .state = r->want.state,
        .is_synced = r->angle.is_synced,
    };
    s->n_in++;
}

static void skip(cam_strobe_t *s, uint32_t n)
{
    s->number += n;
    s->next_tick += n * s->every;
}

void cam_strobe_take(cam_strobe_t *s, const cam_tick_record_t *r)
{
    const uint32_t late = r->tick - s->next_tick;
    if (s->every == 0u || late > UINT32_MAX / 2u) {
        return;
    }
    const uint32_t n_missed = late / s->every + (late % s->every != 0u ? 1u : 0u);
    s->n_lost += n_missed; // with their records
    skip(s, n_missed);
    if (r->tick == s->next_tick) {
        enqueue(s, r);
        skip(s, 1);
    }
}

void cam_strobe_expire(cam_strobe_t *s, uint32_t tick, uint32_t tick_hz)
{
    if (s->every != 0u && tick - s->renewed_tick > tick_hz * (uint32_t)cam_strobe_hold_s) {
        cam_strobe_subscribe(s, 0, tick);
    }
}

const cam_strobe_sample_t *cam_strobe_oldest(const cam_strobe_t *s)
{
    return s->n_in != s->n_out ? &s->queue[s->n_out % (uint32_t)cam_strobe_capacity] : NULL;
}

void cam_strobe_drop(cam_strobe_t *s)
{
    s->n_out++;
}
