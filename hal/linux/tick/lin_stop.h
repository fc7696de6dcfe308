// SPDX-License-Identifier: Apache-2.0
/// lin_stop: controlled end of the program after a signal.
///
///     run --signal--> retract --enable is low--> release --drives rest--> over
///
/// Retract is the firmware's reaction to an emergency stop. A second signal (0.3 s or more after
/// the first) or a retract that takes too long disables the drives at once; they then stop on their
/// own. Pure.
#ifndef LIN_STOP_H
#define LIN_STOP_H

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

#endif
