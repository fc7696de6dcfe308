// SPDX-License-Identifier: Apache-2.0
/// fixture_random: seeded pseudo-random numbers, the same on every machine (xorshift64*).
#ifndef FIXTURE_RANDOM_H
#define FIXTURE_RANDOM_H

#include <stdint.h> // uint64_t

typedef struct {
    uint64_t state; ///< not 0
} fixture_random_t;

static inline uint64_t fixture_random_u64(fixture_random_t *r)
{
    r->state ^= r->state >> 12;
    r->state ^= r->state << 25;
    r->state ^= r->state >> 27;
    return r->state * UINT64_C(2685821657736338717);
}

static inline uint32_t fixture_random_u32(fixture_random_t *r)
{
    return (uint32_t)(fixture_random_u64(r) >> 32);
}

/// @return low .. high, both included
static inline int64_t fixture_random_range(fixture_random_t *r, int64_t low, int64_t high)
{
    const uint64_t span = (uint64_t)high - (uint64_t)low + 1u;
    return (int64_t)((uint64_t)low + fixture_random_u64(r) % span);
}

#endif
