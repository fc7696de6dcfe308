// SPDX-License-Identifier: Apache-2.0
/// sim_clock: when the controller's ticks occur, on its own clock and in machine time.
///
///     k T             timer grid of the controller's clock, T the nominal period
///     k T + e(k)      the tick: the interrupt is late by e(k)
///     / (1 + drift)   in machine time; the clocks of spindle and drives are exact
///
/// jitter: e is evenly distributed from 0 to a share of T. burst: e is that share in one of 16
/// ticks at random, 0 in the others. twice: one tick is repeated, a share of T after the first.
#ifndef SIM_CLOCK_H
#define SIM_CLOCK_H

#include "sim_random.h" // sim_random_t
#include <stdint.h>     // int32_t, uint64_t

typedef struct {
    double drift;  ///< relative error of the controller's clock, above 0: fast; 1e-6: 1 ppm
    double jitter; ///< [periods] below 1
    double burst;  ///< [periods] below 1
    double twice;  ///< [periods] delay of a repeated tick; 0: none
    double rest;   ///< [periods] from the repeated tick to the next; 0: none
    double late;   ///< [periods] delay of the last tick after its grid
    sim_random_t random;
} sim_clock_t;

/// Interval from one tick to the next.
typedef struct {
    double dt_s;         ///< in machine time
    int32_t late_clocks; ///< beyond a period, on the controller's clock; below 0: early
} sim_clock_step_t;

/// Start with an exact clock and punctual ticks.
void sim_clock_init(sim_clock_t *c, uint64_t seed);

/// @param period_s  [s] T
/// @param clock_hz  frequency of the controller's clock
sim_clock_step_t sim_clock_next(sim_clock_t *c, double period_s, double clock_hz);

#endif
