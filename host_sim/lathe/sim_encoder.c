// SPDX-License-Identifier: Apache-2.0
#include "sim_encoder.h"
#include "sim_units.h" // sim_floor, sim_fraction
#include <math.h>      // sin

sim_encoder_config_t sim_encoder_defaults(void)
{
    return (sim_encoder_config_t){
        .counts_per_turn = 10000.0,
        .sign = 1.0,
        .index_turn = 0.3,
        .start_counts = 4294467296.0, // 2^32 - 500 000
    };
}

/// @return the position that the disc shows, as a real number of counts in the sense of rising
/// counts
static double place_counts(const sim_encoder_config_t *c, double turn)
{
    double counts = c->counts_per_turn * turn;
    if (c->eccentricity_counts > 0.0) {
        const double angle = SIM_TWO_PI * sim_fraction(turn - c->eccentricity_turn);
        counts += c->eccentricity_counts * sin(angle);
    }
    return c->sign < 0.0 ? -counts : counts;
}

static double jitter(sim_encoder_t *e)
{
    return e->config.jitter_counts > 0.0 ? e->config.jitter_counts * sim_random_bell(&e->random)
                                         : 0.0;
}

static uint32_t counter(const sim_encoder_config_t *c, int64_t counts)
{
    return (uint32_t)(uint64_t)((int64_t)c->start_counts + counts); // wraps by design
}

static int64_t turns_below(const sim_encoder_t *e, double turn)
{
    return sim_floor(turn - e->config.index_turn);
}

void sim_encoder_init(sim_encoder_t *e, const sim_encoder_config_t *config, double turn,
                      uint64_t seed)
{
    *e = (sim_encoder_t){.config = *config, .random = sim_random_seeded(seed)};
    e->index_counts = sim_floor(place_counts(config, config->index_turn));
    e->n_turns = turns_below(e, turn);
    (void)sim_encoder_read(e, turn);
}

hal_encoder_t sim_encoder_read(sim_encoder_t *e, double turn)
{
    const int64_t n_turns = turns_below(e, turn);
    if (n_turns != e->n_turns) { // the index lies between the two
        const int64_t i_edge = n_turns > e->n_turns ? n_turns : e->n_turns;
        const int64_t whole = i_edge * (int64_t)(e->config.sign * e->config.counts_per_turn);
        const int64_t moved = sim_floor(jitter(e) + 0.5);
        e->reading.index_counts = counter(&e->config, whole + e->index_counts + moved);
        e->reading.n_index++;
        e->n_turns = n_turns;
    }
    const int64_t counts = sim_floor(place_counts(&e->config, turn) + jitter(e));
    e->reading.counts = counter(&e->config, counts);
    return e->reading;
}
