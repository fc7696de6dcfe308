// SPDX-License-Identifier: Apache-2.0
/// sim_clock: when the ticks of the controller come, on its own clock and in the time of the
/// machine.
///
///     k T             the grid of the timer, T nominal periods on the controller's clock
///     k T + e(k)      the tick: the interrupt comes late by e(k)
///     / (1 + drift)   in the time of spindle and drives, whose clocks are right
///
/// jitter: e is spread evenly from 0 to a share of T. burst: e is that share in one of 16 ticks by
/// chance, 0 in the others. twice: one tick comes once more, a share of T behind the first.
#ifndef SIM_CLOCK_H
#define SIM_CLOCK_H

#include "sim_random.h" // sim_random_t
#include <stdint.h>     // int32_t, uint64_t

typedef struct {
    double drift;  ///< by which the controller's clock is fast, 1e-6: 1 ppm
    double jitter; ///< [periods] below 1
    double burst;  ///< [periods] below 1
    double twice;  ///< [periods] of the tick that comes once more; 0: none does
    double rest;   ///< [periods] from that one to the next, 0: none came
    double late;   ///< [periods] of the last tick behind its grid
    sim_random_t random;
} sim_clock_t;

/// The way from a tick to the next.
typedef struct {
    double dt_s;         ///< in the time of the machine
    int32_t late_clocks; ///< beyond a period, on the clock of the controller; below 0: early
} sim_clock_step_t;

/// A right clock, and ticks on time.
void sim_clock_init(sim_clock_t *c, uint64_t seed);

/// @param period_s  [s] T
/// @param clock_hz  of the controller's clock
sim_clock_step_t sim_clock_next(sim_clock_t *c, double period_s, double clock_hz);

#endif
