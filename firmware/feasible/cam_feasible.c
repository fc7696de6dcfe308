// SPDX-License-Identifier: Apache-2.0
#include "cam_feasible_inner.h"

/// [turns] Most feed of a part, ramps included: a day at 3000 r/min. All lengths of
/// cam_feed_motion_t fit their words with it, whatever the override.
enum { most_turns = 1 << 22 };

/// Widths of the ranges that are searched: 2^26 / 1000 = 67 109 r/min and 2^24 nm = 16.8 mm.
enum { speed_bits = 26, feed_bits = 24 };

uint32_t cam_feasible_peak_mrpm(const cam_table_t *table, uint32_t mean_mrpm)
{
    const uint64_t peak = cam_divided_up_u64((uint64_t)mean_mrpm * table->ratio_max_q20,
                                             (uint32_t)CAM_TABLE_RATIO_ONE);
    return peak < UINT32_MAX ? (uint32_t)peak : UINT32_MAX;
}

static void set_speed(cam_cut_t *c, uint32_t mrpm)
{
    c->mean_mrpm = mrpm;
    c->peak_mrpm = cam_feasible_peak_mrpm(c->t, mrpm);
}

/// Set the programmed feed of a cut, and what the override makes of it.
static void set_feed(cam_cut_t *c, uint32_t feed_nm)
{
    c->programmed_nm = feed_nm;
    c->feed_nm =
        cam_divided_up_u64((uint64_t)feed_nm * (uint64_t)cam_changes_feed_ppm(c->p), 1000000);
}

static cam_cut_t cut_of(const cam_table_t *table, const cam_params_t *params, uint32_t speed_mrpm,
                        uint32_t tick_hz)
{
    cam_cut_t c = {.t = table, .p = params, .tick_hz = tick_hz};
    set_feed(&c, params->feed_nm > 0 ? (uint32_t)params->feed_nm : table->feed_nm);
    set_speed(&c, speed_mrpm);
    return c;
}

/// With a feed of a nanometre a tall part takes more turns than cam_feed_motion_t can count. Unlike
/// the demands of the axes (cam_demand_t) this one falls with a rising feed.
static cam_demand_t turns_demand(const cam_cut_t *c)
{
    const uint64_t per_feed = c->t->is_ring_helix ? 2u : 1u; // a ring follows each turn of feed
    const uint64_t fed = per_feed * cam_divided_up_u64(cam_cut_span_nm(c), c->programmed_nm);
    return (cam_demand_t){cam_err_turns, most_turns, fed + (uint64_t)c->p->feed_ramp_turns};
}

/// @return the first limit that the cut exceeds, of an axis or of the turns
static cam_demand_t first_exceeded(const cam_cut_t *c)
{
    const cam_demand_t axes = cam_demand_first_exceeded(c);
    const cam_demand_t turns = turns_demand(c);
    return axes.err == cam_ok && turns.needed > (uint64_t)turns.limit ? turns : axes;
}

cam_demand_t cam_feasible_demands(const cam_table_t *table, const cam_params_t *params,
                                  uint32_t speed_mrpm, uint32_t tick_hz, cam_demands_t *axes)
{
    const cam_cut_t c = cut_of(table, params, speed_mrpm, tick_hz);
    *axes = cam_demand_all(&c);
    return turns_demand(&c);
}

cam_err_t cam_feasible_check(const cam_table_t *table, const cam_params_t *params,
                             uint32_t speed_mrpm, uint32_t tick_hz)
{
    const cam_cut_t c = cut_of(table, params, speed_mrpm, tick_hz);
    return first_exceeded(&c).err;
}

/// No demand falls with rising speed or feed, so the bits of the highest feasible value can be
/// found from the highest one downwards.
static uint32_t highest(cam_cut_t *c, void (*set)(cam_cut_t *c, uint32_t value), uint32_t n_bits)
{
    uint32_t found = 0;
    for (uint32_t bit = UINT32_C(1) << (n_bits - 1u); bit != 0u; bit >>= 1) {
        set(c, found + bit);
        found += cam_demand_first_exceeded(c).err == cam_ok ? bit : 0u;
    }
    return found;
}

uint32_t cam_feasible_highest_mrpm(const cam_table_t *table, const cam_params_t *params,
                                   uint32_t tick_hz)
{
    cam_cut_t c = cut_of(table, params, 0, tick_hz);
    return highest(&c, set_speed, speed_bits);
}

uint32_t cam_feasible_largest_feed_nm(const cam_table_t *table, const cam_params_t *params,
                                      uint32_t speed_mrpm, uint32_t tick_hz)
{
    cam_cut_t c = cut_of(table, params, speed_mrpm, tick_hz);
    return highest(&c, set_feed, feed_bits);
}

cam_refusal_t cam_feasible(const cam_table_t *table, const cam_params_t *params,
                           uint32_t speed_mrpm, uint32_t tick_hz)
{
    const cam_cut_t c = cut_of(table, params, speed_mrpm, tick_hz);
    const cam_demand_t exceeded = first_exceeded(&c);
    return (cam_refusal_t){
        .err = exceeded.err,
        .param = cam_n_params,
        .speed_mrpm = speed_mrpm,
        .highest_mrpm = cam_feasible_highest_mrpm(table, params, tick_hz),
        .largest_feed_nm = cam_feasible_largest_feed_nm(table, params, speed_mrpm, tick_hz),
        .needed = (int64_t)exceeded.needed,
        .limit = exceeded.limit,
    };
}
