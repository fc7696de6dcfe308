// SPDX-License-Identifier: Apache-2.0
#include "sim_encoder.h"
#include "sim_units.h" // sim_sine, sim_clamp, sim_floor

/// @return position of the disc in counts from angle 0, a real number, rising with the counter
static double disc_counts(const sim_encoder_config_t *c, double turn)
{
    double counts = c->counts_per_turn * turn;
    if (c->eccentricity_counts > 0.0) {
        counts += c->eccentricity_counts * sim_sine(turn - c->eccentricity_turn);
    }
    return c->sign < 0.0 ? -counts : counts;
}

/// @return the same from an edge of a count on, on which the index is
static double place_counts(const sim_encoder_t *e, double turn)
{
    return disc_counts(&e->config, turn) + e->index_counts_off;
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
    const double index_counts = disc_counts(config, config->index_turn);
    e->index_counts = sim_floor(index_counts + 0.5);
    e->index_counts_off = (double)e->index_counts - index_counts;
    e->n_turns = turns_below(e, turn);
    (void)sim_encoder_read(e, turn);
    e->stamped_counts = e->counts;
    e->turn = turn;
}

hal_encoder_t sim_encoder_read(sim_encoder_t *e, double turn)
{
    const int64_t n_turns = turns_below(e, turn);
    if (n_turns != e->n_turns) { // the index is between the two readings
        const int64_t i_edge = n_turns > e->n_turns ? n_turns : e->n_turns;
        const int64_t whole = i_edge * (int64_t)(e->config.sign * e->config.counts_per_turn);
        const int64_t moved = sim_floor(jitter(e) + 0.5);
        e->reading.index_counts = counter(&e->config, whole + e->index_counts + moved);
        e->reading.n_index++;
        e->n_turns = n_turns;
    }
    e->jitter_counts = jitter(e);
    e->counts = sim_floor(place_counts(e, turn) + e->jitter_counts);
    e->reading.counts = counter(&e->config, e->counts);
    return e->reading;
}

/// @return [turn] angle at which the disc shows `place`, a real number of counts
static double turn_of(const sim_encoder_t *e, double place)
{
    const sim_encoder_config_t *c = &e->config;
    const double straight = c->sign * place / c->counts_per_turn;
    double turn = straight;
    for (int i = 0; i < 6; i++) { // converges by 2 pi e / N each time
        turn += straight - c->sign * place_counts(e, turn) / c->counts_per_turn;
    }
    return turn;
}

/// @return time at which the spindle passed an angle, as a share 0 .. 1 of the time between two
///         readings
static double passed_at(const sim_encoder_t *e, double to_turn, double to_speed, double dt_s,
                        double turn)
{
    const double gone = to_turn - e->turn;
    const double v0 = e->speed_turns_per_s * dt_s;
    const double v1 = to_speed * dt_s;
    const double square = 3.0 * gone - 2.0 * v0 - v1;
    const double cube = v0 + v1 - 2.0 * gone;
    double x = gone != 0.0 ? (turn - e->turn) / gone : 1.0;
    for (int i = 0; i < 4 && gone != 0.0; i++) {
        const double at = e->turn + x * (v0 + x * (square + x * cube));
        x += (turn - at) / gone;
    }
    return sim_clamp(x, 0.0, 1.0);
}

void sim_encoder_stamp(sim_encoder_t *e, double turn, double speed_turns_per_s, double dt_s)
{
    e->edge_age_s += dt_s;
    if (e->counts != e->stamped_counts) {
        const int64_t edge = e->counts > e->stamped_counts ? e->counts : e->counts + 1;
        const double edge_turn = turn_of(e, (double)edge - e->jitter_counts);
        e->edge_age_s = dt_s * (1.0 - passed_at(e, turn, speed_turns_per_s, dt_s, edge_turn));
    }
    e->stamped_counts = e->counts;
    e->turn = turn;
    e->speed_turns_per_s = speed_turns_per_s;
}
