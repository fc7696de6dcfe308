// SPDX-License-Identifier: Apache-2.0
#include "sim_port.h"
#include "sim_units.h" // sim_round

enum { burst_of = 16 }; ///< one tick of this many is late, on average

void sim_clock_init(sim_clock_t *c, uint64_t seed)
{
    *c = (sim_clock_t){.random = sim_random_seeded(seed)};
}

/// @return a number evenly distributed over 0 .. 1
static double even(sim_clock_t *c)
{
    return (double)(sim_random_next(&c->random) >> 11) * 0x1p-53;
}

/// @return [periods] delay of the next tick after its grid
static double lateness(sim_clock_t *c)
{
    double late = c->jitter > 0.0 ? c->jitter * even(c) : 0.0;
    if (c->burst > 0.0 && even(c) * burst_of < 1.0) {
        late = c->burst;
    }
    return late;
}

/// @return [periods] to the next tick, less one
static double beyond(sim_clock_t *c)
{
    if (c->rest > 0.0) { // the tick after a repeated one is on the grid again
        const double rest = c->rest;
        c->rest = 0.0;
        return rest - 1.0;
    }
    if (c->twice > 0.0) {
        const double twice = c->twice;
        c->twice = 0.0;
        c->rest = 1.0 - twice;
        return twice - 1.0;
    }
    const double late = lateness(c);
    const double more = late - c->late;
    c->late = late;
    return more;
}

sim_clock_step_t sim_clock_next(sim_clock_t *c, double period_s, double clock_hz)
{
    const double more = beyond(c);
    return (sim_clock_step_t){
        .dt_s = period_s * (1.0 + more) / (1.0 + c->drift),
        .late_clocks = (int32_t)sim_round(more * period_s * clock_hz),
    };
}
