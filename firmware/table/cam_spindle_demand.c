// SPDX-License-Identifier: Apache-2.0
#include "cam_spindle_demand.h"
#include "cam_fix.h"   // cam_per_rad
#include "cam_speed.h" // cam_speed_scaled

/// @return [2^-20] a derivative per turn as one per rad, rounded away from 0
static int64_t per_rad_q20(int64_t per_turn_q20)
{
    const int64_t magnitude = cam_per_rad(cam_abs_i64(per_turn_q20)) + 1;
    return per_turn_q20 < 0 ? -magnitude : magnitude;
}

static uint32_t raised(uint32_t most, int64_t value)
{
    return value > (int64_t)most ? (uint32_t)value : most;
}

/// Raise the demand to that of one knot.
static void raise_demand(cam_spindle_demand_t *demand, cam_ratio_t at)
{
    const int64_t slope_q20 = per_rad_q20(at.slope_q20);
    const int64_t product_q20 = per_rad_q20(((int64_t)at.ratio_q28 * at.slope_q20) >> 28);
    const int64_t ratio_q20 = ((int64_t)at.ratio_q28 >> 8) + 1;
    demand->fall_ppm_per_rad = raised(demand->fall_ppm_per_rad, (-slope_q20 * 1000000) >> 20);
    demand->rise_q20 = raised(demand->rise_q20, product_q20);
    for (int k = 0; k < cam_spindle_demand_places; k++) {
        demand->set_q20[k] = raised(demand->set_q20[k],
                                    ratio_q20 + product_q20 * k * k / cam_spindle_demand_per_rad);
    }
}

cam_spindle_demand_t cam_spindle_demand_of(const cam_channel_t *ch)
{
    cam_spindle_demand_t demand = {0};
    for (int k = 0; k < cam_spindle_demand_places; k++) {
        demand.set_q20[k] = (uint32_t)CAM_TABLE_RATIO_ONE;
    }
    const uint32_t n = ch->knots != NULL ? ch->n_slices << ch->log2_knots : 0u;
    for (uint32_t i = 0; i < n; i++) {
        const cam_value_t at = {.y = ch->knots[i].p, .d1 = ch->knots[i].v};
        raise_demand(&demand, cam_speed_scaled(ch, at));
    }
    return demand;
}

uint64_t cam_spindle_demand_set_q20(const cam_spindle_demand_t *demand, uint64_t c_q16)
{
    const uint64_t one_q16 = 65536u / (uint64_t)cam_spindle_demand_per_rad; // c of the first step
    uint64_t k = 0;
    while (k + 1u < (uint64_t)cam_spindle_demand_places && (k + 1u) * (k + 1u) * one_q16 <= c_q16) {
        k++;
    }
    const uint64_t from = demand->set_q20[k];
    const uint64_t beyond_q16 = c_q16 - k * k * one_q16;
    if (k + 1u == (uint64_t)cam_spindle_demand_places) {
        return from + ((demand->rise_q20 * beyond_q16) >> 16) + 1u;
    }
    const uint64_t to = demand->set_q20[k + 1u];
    return from + (to > from ? (to - from) * beyond_q16 / ((2u * k + 1u) * one_q16) : 0u) + 1u;
}
