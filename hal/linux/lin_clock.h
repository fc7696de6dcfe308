// SPDX-License-Identifier: Apache-2.0
/// lin_clock: the clock of the port, CLOCK_MONOTONIC in ns.
#ifndef LIN_CLOCK_H
#define LIN_CLOCK_H

#include <stdint.h> // int64_t
#include <time.h>   // clock_gettime

enum { lin_ns_per_s = 1000000000 };

static inline int64_t lin_clock_of(const struct timespec *t)
{
    return (int64_t)t->tv_sec * lin_ns_per_s + t->tv_nsec;
}

static inline int64_t lin_clock_read(clockid_t clock)
{
    struct timespec t;
    (void)clock_gettime(clock, &t);
    return lin_clock_of(&t);
}

/// @return [ns] CLOCK_MONOTONIC now
static inline int64_t lin_clock_now(void)
{
    return lin_clock_read(CLOCK_MONOTONIC);
}

#endif
