// SPDX-License-Identifier: Apache-2.0
#include "cam_feasible.h"
#include "cam_demand.h" // cam_demand_first_exceeded

/// Ranges in which the highest speed and the largest feed are looked for: all bits set.
enum { speed_bits = 26, feed_bits = 24 };

uint32_t cam_feasible_peak(const cam_table_t *table, uint32_t mean_mrpm)
{
    const uint64_t peak = ((uint64_t)mean_mrpm * table->ratio_max_q20 + CAM_TABLE_RATIO_ONE - 1u) /
                          (uint32_t)CAM_TABLE_RATIO_ONE;
    return peak < UINT32_MAX ? (uint32_t)peak : UINT32_MAX;
}

static void set_speed(cam_cut_t *c, uint32_t mrpm)
{
    c->mean_mrpm = mrpm;
    c->peak_mrpm = cam_feasible_peak(c->t, mrpm);
}

/// @return the highest speed at which no limit is exceeded, by halving
static uint32_t highest_mrpm(cam_cut_t c)
{
    uint32_t highest = 0;
    for (uint32_t bit = UINT32_C(1) << (speed_bits - 1); bit != 0u; bit >>= 1) {
        set_speed(&c, highest + bit);
        highest += cam_demand_first_exceeded(&c).err == cam_ok ? bit : 0u;
    }
    return highest;
}

/// @return the largest feed
static uint32_t largest_feed_nm(cam_cut_t c)
{
    uint32_t largest = 0;
    for (uint32_t bit = UINT32_C(1) << (feed_bits - 1); bit != 0u; bit >>= 1) {
        c.feed_nm = (uint64_t)largest + bit;
        largest += cam_demand_first_exceeded(&c).err == cam_ok ? bit : 0u;
    }
    return largest;
}

cam_feasibility_t cam_feasible(const cam_table_t *table, const cam_params_t *params,
                               uint32_t speed_mrpm, uint32_t tick_hz)
{
    cam_cut_t c = {.t = table,
                   .p = params,
                   .tick_hz = tick_hz,
                   .feed_nm = params->feed_nm > 0 ? (uint64_t)params->feed_nm : table->feed_nm};
    set_speed(&c, speed_mrpm);
    const cam_demand_t exceeded = cam_demand_first_exceeded(&c);
    return (cam_feasibility_t){
        .err = exceeded.err,
        .speed_mrpm = speed_mrpm,
        .highest_mrpm = highest_mrpm(c),
        .largest_feed_nm = largest_feed_nm(c),
        .needed = (int64_t)exceeded.needed,
        .limit = exceeded.limit,
    };
}
