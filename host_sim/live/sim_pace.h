// SPDX-License-Identifier: Apache-2.0
/// sim_pace: virtual time keeps pace with the clock, or with a multiple of it.
///
/// Ticks come in bursts of about a millisecond, since a computer cannot sleep for 50 us. What a
/// computer that is too slow falls behind is made up for as long as it is below 0.1 s; more is
/// given up, so that a lathe that was held up does not run wild afterwards.
#ifndef SIM_PACE_H
#define SIM_PACE_H

#include <stdint.h> // int64_t

typedef struct {
    double tick_ns; ///< [ns] of the clock that a tick takes
    double due_ns;  ///< [ns] when the next tick is due
    double lost_ns; ///< [ns] given up so far
} sim_pace_t;

/// Begin now. @param speed_up  how many times faster than the clock
void sim_pace_init(sim_pace_t *p, double tick_hz, double speed_up);

/// A tick is over: sleep when the next one is due in more than a millisecond.
void sim_pace_tick(sim_pace_t *p);

#endif
