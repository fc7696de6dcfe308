// SPDX-License-Identifier: Apache-2.0
/// sim_random: a small seeded generator, so that a run repeats bit for bit on every computer.
/// Source: S. Vigna, "An experimental exploration of Marsaglia's xorshift generators, scrambled",
/// ACM TOMS 42(4), 2016, xorshift64*; seeded through the splitmix64 finaliser.
#ifndef SIM_RANDOM_H
#define SIM_RANDOM_H

#include <stdint.h> // uint64_t

typedef struct {
    uint64_t state; ///< never 0
} sim_random_t;

static inline sim_random_t sim_random_seeded(uint64_t seed)
{
    uint64_t z = seed + UINT64_C(0x9E3779B97F4A7C15);
    z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
    z ^= z >> 31;
    return (sim_random_t){.state = z != 0u ? z : 1u};
}

static inline uint64_t sim_random_next(sim_random_t *r)
{
    r->state ^= r->state >> 12;
    r->state ^= r->state << 25;
    r->state ^= r->state >> 27;
    return r->state * UINT64_C(0x2545F4914F6CDD1D);
}

/// Bell-shaped noise: the sum of four uniform 16-bit numbers (Irwin-Hall), scaled.
/// @return mean 0, standard deviation 1, within +-3.47
static inline double sim_random_bell(sim_random_t *r)
{
    const uint64_t bits = sim_random_next(r);
    const uint64_t sum =
        (bits & 0xFFFFu) + ((bits >> 16) & 0xFFFFu) + ((bits >> 32) & 0xFFFFu) + (bits >> 48);
    return ((double)sum - 131070.0) * (1.7320508075688772 / 65536.0);
}

#endif
