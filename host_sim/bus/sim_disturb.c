// SPDX-License-Identifier: Apache-2.0
#include "sim_bus.h"

void sim_disturb_begin(sim_disturb_t *d, sim_disturb_kind_t kind, uint32_t n, double late_s)
{
    d->kind = kind;
    d->n_left = n;
    d->late_s = late_s;
}

static void remove_frame(sim_frames_t *queue, uint32_t i)
{
    queue->n--;
    for (; i < queue->n; i++) {
        queue->frame[i] = queue->frame[i + 1u];
    }
}

static void hold(sim_disturb_t *d, sim_frames_t *queue, uint32_t i, double until_s)
{
    d->held = queue->frame[i];
    d->is_held = true;
    d->held_until_s = until_s;
    remove_frame(queue, i);
}

static void disturb(sim_disturb_t *d, sim_frames_t *queue, uint32_t i, double t_s)
{
    d->n_left--;
    switch (d->kind) {
    case sim_disturb_missing:
        remove_frame(queue, i);
        break;
    case sim_disturb_repeated:
        queue->frame[i] = d->has_last ? d->last : queue->frame[i];
        break;
    case sim_disturb_swapped:
        if (!d->is_held) { // the first frame of a pair waits
            d->n_left++;   // the pair is not complete
            hold(d, queue, i, t_s);
        } else { // the second frame is sent before the first
            *sim_frames_add(queue, d->held.id) = d->held;
            d->is_held = false;
        }
        break;
    case sim_disturb_late:
        hold(d, queue, i, t_s + d->late_s);
        break;
    case sim_disturb_none:
        break;
    }
}

void sim_disturb_pass(sim_disturb_t *d, sim_frames_t *queue, uint32_t id, double t_s)
{
    uint32_t i = 0;
    while (i < queue->n && queue->frame[i].id != id) {
        i++;
    }
    if (i == queue->n) {
        return;
    }
    const sim_frame_t original = queue->frame[i];
    if (d->n_left > 0u) {
        disturb(d, queue, i, t_s);
        if (d->kind == sim_disturb_repeated) {
            return;
        }
    }
    d->last = original;
    d->has_last = true;
}

bool sim_disturb_due(sim_disturb_t *d, double before_s, sim_frame_t *frame, double *at_s)
{
    if (!d->is_held || d->kind != sim_disturb_late || d->held_until_s >= before_s) {
        return false;
    }
    *frame = d->held;
    *at_s = d->held_until_s;
    d->is_held = false;
    return true;
}
