// SPDX-License-Identifier: Apache-2.0
#include "lin_bus.h"

void lin_encoder_init(lin_encoder_t *e, const lin_encoder_config_t *config, int64_t tick_hz)
{
    *e = (lin_encoder_t){.config = *config, .least_ns = INT64_C(1000000000) / tick_hz / 4};
    e->config.max_age_us = lin_config_age_us(config, tick_hz);
}

/// @return the increment from the last raw position, in the shorter direction
static int64_t increment(const lin_encoder_t *e, uint32_t raw)
{
    const int64_t modulus = e->config.modulus_counts;
    if (modulus == 0) {
        return (int32_t)(raw - e->raw); // wraps by design
    }
    const int64_t moved = (int64_t)raw - (int64_t)e->raw;
    return moved > modulus / 2 ? moved - modulus : moved < -modulus / 2 ? moved + modulus : moved;
}

static int64_t counts_at(const lin_encoder_t *e, int64_t ns)
{
    const int64_t dt_ns = e->ns - e->before_ns;
    return dt_ns == 0 ? e->counts
                      : e->counts + lin_div_round((e->counts - e->before) * (ns - e->ns), dt_ns);
}

static void close_edge(lin_encoder_t *e)
{
    if (e->is_edge_open && e->edge_ns <= e->ns) {
        e->index_counts = counts_at(e, e->edge_ns);
        e->n_index++;
        e->is_edge_open = false;
    }
}

/// Detect a pass of index_counts + k turns; both directions of rotation latch the same number.
static void find_index(lin_encoder_t *e, int64_t from)
{
    const int64_t turn = e->config.counts_per_turn;
    const int64_t index = e->config.index_counts;
    const int64_t turns_before = lin_div_floor(from - index, turn);
    const int64_t turns = lin_div_floor(e->counts - index, turn);
    if (turns != turns_before) {
        e->index_counts = index + turn * (turns > turns_before ? turns : turns + 1);
        e->n_index +=
            (uint32_t)(turns > turns_before ? turns - turns_before : turns_before - turns);
    }
}

/// Measure the speed from a frame that is at least least_ns old. If frames are closer together than
/// that, it is at most twice as old.
static void choose_base(lin_encoder_t *e, int64_t at_ns)
{
    if (at_ns - e->ns >= e->least_ns) {
        e->mark = e->counts;
        e->mark_ns = e->ns;
    }
    if (at_ns - e->mark_ns >= e->least_ns) {
        e->before = e->mark;
        e->before_ns = e->mark_ns;
        e->mark = e->counts;
        e->mark_ns = e->ns;
    }
}

void lin_encoder_receive(lin_encoder_t *e, uint32_t raw, int64_t ns)
{
    const int64_t at_ns = ns - e->config.delay_ns;
    if (!e->has_frame) {
        e->has_frame = true;
        e->counts = raw;
        e->before = raw;
        e->before_ns = at_ns;
        e->mark = raw;
        e->mark_ns = at_ns;
    } else {
        const int64_t from = e->counts;
        choose_base(e, at_ns);
        e->counts += increment(e, raw);
        if (e->config.index == lin_index_position) {
            find_index(e, from);
        }
    }
    e->raw = raw;
    e->ns = at_ns;
    close_edge(e);
}

void lin_encoder_edge(lin_encoder_t *e, int64_t ns, bool is_rising)
{
    const bool is_positive = e->counts >= e->before;
    if (e->config.index != lin_index_line || is_rising != is_positive || !e->has_frame) {
        return;
    }
    e->edge_ns = ns;
    e->is_edge_open = true;
    close_edge(e);
}

hal_encoder_t lin_encoder_at(const lin_encoder_t *e, int64_t ns)
{
    const int64_t latest_ns = e->ns + e->config.max_age_us * 1000;
    return (hal_encoder_t){
        .counts = (uint32_t)counts_at(e, ns < latest_ns ? ns : latest_ns),
        .index_counts = (uint32_t)e->index_counts,
        .n_index = e->n_index,
    };
}

bool lin_encoder_is_fresh(const lin_encoder_t *e, int64_t ns)
{
    return e->has_frame && ns - e->ns <= e->config.max_age_us * 1000;
}
