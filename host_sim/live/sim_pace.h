// SPDX-License-Identifier: Apache-2.0
/// sim_pace: paces virtual time by the clock, or a multiple of it.
///
/// Ticks come in bursts of about a millisecond, since a computer cannot sleep for 50 us. A slow
/// computer catches up on a delay of up to 0.1 s; longer delays are dropped, so that a lathe that
/// was held up does not rush afterwards.
#ifndef SIM_PACE_H
#define SIM_PACE_H

#include <stdint.h> // int64_t

typedef struct {
    double tick_ns; ///< [ns] clock time of a tick
    double due_ns;  ///< [ns] when the next tick is due
    double lost_ns; ///< [ns] delay dropped so far
} sim_pace_t;

/// Start now. @param speed_up  times faster than the clock
void sim_pace_init(sim_pace_t *p, double tick_hz, double speed_up);

/// End a tick: sleep if the next one is due in more than a millisecond.
void sim_pace_tick(sim_pace_t *p);

#endif
