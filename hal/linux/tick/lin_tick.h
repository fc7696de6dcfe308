// SPDX-License-Identifier: Apache-2.0
/// lin_tick: times of the ticks, and the controlled end of the program after a signal.
///
///     run --signal--> retract --enable is low--> release --drives rest--> over
///
/// Retract is the firmware's reaction to an emergency stop. A second signal (0.3 s or more after
/// the first) or a retract that takes too long disables the drives at once; they then stop on their
/// own. Pure.
#ifndef LIN_TICK_H
#define LIN_TICK_H

#include <stdbool.h> // bool
#include <stdint.h>  // int64_t, uint32_t

typedef enum { lin_stop_run, lin_stop_retract, lin_stop_release, lin_stop_over } lin_stop_phase_t;

typedef struct {
    lin_stop_phase_t phase;
    int64_t since_ns;   ///< start of the phase
    uint32_t n_ticks;   ///< in release
    uint32_t n_signals; ///< signals that count as the first one
} lin_stop_t;

/// Step the state machine once per tick; a zero-initialised state is lin_stop_run.
/// @param n_signals   number of signals so far
/// @param outputs     hal_out_* of the last tick
/// @param is_at_rest  no drive is enabled
/// @return            phase of this tick
lin_stop_phase_t lin_stop_step(lin_stop_t *s, uint32_t n_signals, uint32_t outputs, bool is_at_rest,
                               int64_t now_ns);

// Ticks are due i / tick_hz after each full second, i = 0, 1, 2 ..., so that a period
// that is not a whole number of nanoseconds does not accumulate an error. Pure.

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
