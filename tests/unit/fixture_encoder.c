// SPDX-License-Identifier: Apache-2.0
#include "fixture_encoder.h"
#include <math.h> // floorl

void fixture_encoder_init(fixture_encoder_t *e, int32_t counts_per_turn, int32_t sense,
                          uint32_t base, int32_t index_at)
{
    *e = (fixture_encoder_t){
        .counts_per_turn = counts_per_turn, .sense = sense, .base = base, .index_at = index_at};
    e->reading.counts = base;
}

static int64_t edges_below(const fixture_encoder_t *e, long double at)
{
    // An edge at a boundary of counts is passed when the counter passes it.
    return (int64_t)floorl((floorl(at) - e->index_at) / e->counts_per_turn);
}

hal_encoder_t fixture_encoder_move(fixture_encoder_t *e, long double turns)
{
    const int64_t before = edges_below(e, e->at);
    e->at += turns * e->counts_per_turn * e->sense;
    const int64_t after = edges_below(e, e->at);
    const uint32_t shift = e->base + (uint32_t)e->lost;
    e->reading.counts = (uint32_t)(uint64_t)(int64_t)floorl(e->at) + shift;
    if (after != before) {
        const int64_t edge = after > before ? after : before;
        e->reading.index_counts =
            (uint32_t)(uint64_t)(e->index_at + edge * e->counts_per_turn) + shift;
        e->reading.n_index +=
            (uint32_t)(uint64_t)(after > before ? after - before : before - after);
    }
    return e->reading;
}

long double fixture_encoder_turns(const fixture_encoder_t *e)
{
    return (e->at - e->index_at) * e->sense / e->counts_per_turn;
}
