// SPDX-License-Identifier: Apache-2.0
#include "sim_lathe.h"
#include "sim_units.h" // sim_round, SIM_NM_PER_MM
#include <math.h>      // floor

void sim_home_init(sim_home_t *h, const sim_home_config_t *config, double place_mm)
{
    *h = (sim_home_t){
        .config = *config,
        .is_used = config->side != 0.0 || config->pitch_mm > 0.0,
        .zero_nm = (int32_t)sim_round(config->zero_mm * SIM_NM_PER_MM),
        .last_mm = place_mm,
    };
}

/// @return whether an index is between two positions
static bool is_index_between(const sim_home_config_t *c, double from_mm, double to_mm)
{
    return c->pitch_mm > 0.0 &&
           floor((from_mm - c->zero_mm) / c->pitch_mm) != floor((to_mm - c->zero_mm) / c->pitch_mm);
}

void sim_home_look(sim_home_t *h, double place_mm, uint32_t n_shown)
{
    const sim_home_config_t *c = &h->config;
    const double beyond_mm = c->side * (place_mm - c->switch_mm);
    h->n_left -= h->n_left > 0u ? 1u : 0u;
    h->n_left = is_index_between(c, h->last_mm, place_mm) ? n_shown : h->n_left;
    h->last_mm = place_mm;
    h->is_on = c->side != 0.0 && beyond_mm >= 0.0;
    h->is_seen = h->n_left > 0u;
}
