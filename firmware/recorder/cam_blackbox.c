// SPDX-License-Identifier: Apache-2.0
#include "cam_recorder.h"
#include "hal/hal.h" // hal_scope_keep
#include <string.h>  // memcpy

/// Head of the kept recording. The layout number changes with the signal numbers.
typedef struct {
    uint32_t layout;
    uint32_t signals;
    uint32_t tick_hz;
    uint32_t every;
    uint32_t before;
    cam_scope_ring_t ring;
    uint32_t end;
} head_t;
_Static_assert(sizeof(head_t) == 56, "another head needs another layout number");

enum { layout_1 = 0x31584243, head_words = sizeof(head_t) / sizeof(int32_t), ms_per_s = 1000 };

/// @return rows of a time, at least one
static uint32_t rows_of(uint32_t ms, const cam_scope_t *s, uint32_t every)
{
    const uint32_t ticks = s->tick_hz * ms / (uint32_t)ms_per_s;
    const uint32_t rows = (ticks + every - 1u) / every;
    return rows > 0u ? rows : 1u;
}

cam_err_t cam_blackbox_begin(cam_scope_t *s, uint32_t tick)
{
    const uint32_t taken = s->n_wave + (uint32_t)head_words;
    const uint32_t room = s->n_words > taken ? s->n_words - taken : 0u;
    const uint32_t fitting = room / cam_scope_count(CAM_BLACKBOX_SIGNALS);
    if (fitting < 2u) {
        return cam_err_scope_memory;
    }
    uint32_t every = 1;
    while (rows_of(cam_blackbox_before_ms, s, every) + rows_of(cam_blackbox_after_ms, s, every) >
           fitting) {
        every++;
    }
    const uint32_t before = rows_of(cam_blackbox_before_ms, s, every);
    const cam_scope_plan_t plan = {
        .signals = CAM_BLACKBOX_SIGNALS,
        .every = every,
        .rows = before + rows_of(cam_blackbox_after_ms, s, every),
        .before = before,
        .from_state = -1,
        .trigger = {.kind = cam_trigger_fault},
    };
    return cam_scope_begin(s, &plan, cam_scope_box, head_words, tick);
}

void cam_blackbox_keep(const cam_scope_t *s)
{
    const head_t head = {
        .layout = layout_1,
        .signals = s->plan.signals,
        .tick_hz = s->tick_hz,
        .every = s->plan.every,
        .before = s->plan.before,
        .ring = s->ring,
        .end = (uint32_t)s->end,
    };
    int32_t *begin = &s->words[s->at - (uint32_t)head_words];
    (void)memcpy((uint8_t *)begin, (const uint8_t *)&head, sizeof head);
    hal_scope_keep(begin, (uint32_t)head_words + s->ring.most_rows * s->n_signals);
}

static bool is_head_valid(const head_t *h, const cam_scope_t *s, uint32_t n_kept)
{
    const uint32_t n_signals = cam_scope_count(CAM_BLACKBOX_SIGNALS);
    return h->layout == (uint32_t)layout_1 && h->signals == CAM_BLACKBOX_SIGNALS &&
           h->tick_hz == s->tick_hz && h->every >= 1u && h->ring.most_rows >= 1u &&
           h->ring.most_rows == (n_kept - (uint32_t)head_words) / n_signals &&
           h->ring.oldest < h->ring.most_rows && h->ring.n_rows <= h->ring.most_rows &&
           h->ring.n_before <= h->ring.n_rows && h->end <= (uint32_t)cam_scope_gap;
}

bool cam_blackbox_restore(cam_scope_t *s, uint32_t n_kept)
{
    head_t head;
    if (n_kept <= (uint32_t)head_words || n_kept > s->n_words) {
        return false;
    }
    (void)memcpy((uint8_t *)&head, (const uint8_t *)s->words, sizeof head);
    if (!is_head_valid(&head, s, n_kept) || cam_blackbox_begin(s, 0) != cam_ok) {
        return false;
    }
    s->plan.every = head.every;
    s->plan.before = head.before;
    s->ring = head.ring;
    s->end = (cam_scope_end_t)head.end;
    s->phase = cam_scope_done;
    return true;
}
