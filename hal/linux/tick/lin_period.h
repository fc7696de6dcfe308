// SPDX-License-Identifier: Apache-2.0
/// lin_period: ticks are due i / tick_hz after each full second, i = 0, 1, 2 ..., so that a period
/// that is not a whole number of nanoseconds does not accumulate an error. Pure.
#ifndef LIN_PERIOD_H
#define LIN_PERIOD_H

#include <stdint.h> // int64_t, uint32_t

#define LIN_PERIOD_SECOND_NS INT64_C(1000000000)

/// @return [ns] time of the first tick after now; now >= 0
static inline int64_t lin_period_next(int64_t now_ns, int64_t tick_hz)
{
    const int64_t second_ns = now_ns / LIN_PERIOD_SECOND_NS * LIN_PERIOD_SECOND_NS;
    const int64_t i = (now_ns - second_ns) * tick_hz / LIN_PERIOD_SECOND_NS;
    const int64_t next_ns = second_ns + (i + 1) * LIN_PERIOD_SECOND_NS / tick_hz;
    return next_ns > now_ns ? next_ns : second_ns + (i + 2) * LIN_PERIOD_SECOND_NS / tick_hz;
}

/// @return number of ticks between two tick times, exclusive
static inline uint32_t lin_period_missed(int64_t last_ns, int64_t next_ns, int64_t tick_hz)
{
    const int64_t seconds = (next_ns - last_ns) / LIN_PERIOD_SECOND_NS;
    const int64_t rest_ns = (next_ns - last_ns) % LIN_PERIOD_SECOND_NS;
    const int64_t periods = (rest_ns * tick_hz + LIN_PERIOD_SECOND_NS / 2) / LIN_PERIOD_SECOND_NS;
    return (uint32_t)(seconds * tick_hz + periods - 1);
}

#endif
