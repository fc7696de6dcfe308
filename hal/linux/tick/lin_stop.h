// SPDX-License-Identifier: Apache-2.0
/// lin_stop: how the program ends after a signal.
///
///     run --signal--> retract --enable is low--> release --drives rest--> over
///
/// Retract is the firmware's own reaction to an emergency stop: the tool leaves the work. After a
/// second signal, which is one that comes 0.3 s behind the first or later, or when retracting takes
/// too long, the drives are disabled at once and stop by themselves.
/// Pure.
#ifndef LIN_STOP_H
#define LIN_STOP_H

#include <stdbool.h> // bool
#include <stdint.h>  // int64_t, uint32_t

typedef enum { lin_stop_run, lin_stop_retract, lin_stop_release, lin_stop_over } lin_stop_phase_t;

typedef struct {
    lin_stop_phase_t phase;
    int64_t since_ns;   ///< of the phase
    uint32_t n_ticks;   ///< in release
    uint32_t n_signals; ///< that were one wish
} lin_stop_t;

/// One step of the end; a zero-initialised state is lin_stop_run.
/// @param n_signals   so far
/// @param outputs     hal_out_* of the last tick
/// @param is_at_rest  no drive is in operation
/// @return            phase of this tick
lin_stop_phase_t lin_stop_step(lin_stop_t *s, uint32_t n_signals, uint32_t outputs, bool is_at_rest,
                               int64_t now_ns);

#endif
