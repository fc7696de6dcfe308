// SPDX-License-Identifier: Apache-2.0
/// sim_switches: where the position switches really act, compared with the commanded windows.
///
/// Each output drives a device that acts a dead time after the output changes. The true spindle
/// angle at that instant, interpolated linearly between ticks, is compared with the ends of the
/// window. A change farther from the end than an eighth of the window distance has another cause
/// than the angle (height, state, sense of rotation) and is counted separately.
#ifndef SIM_SWITCHES_H
#define SIM_SWITCHES_H

#include <stdbool.h> // bool
#include <stdint.h>  // uint32_t

enum { sim_switches_n = 8, sim_switches_pending = 64 };

/// A commanded window.
typedef struct {
    double per_turn; ///< 0: the switch is not in use
    double on_turn, off_turn;
    double dead_time_s;
} sim_switch_window_t;

/// Changes of one kind: on, or off.
typedef struct {
    uint32_t n;                    ///< at an end of the window
    uint32_t n_other;              ///< elsewhere
    double sum_turn, largest_turn; ///< deviation from the end, above 0 towards rising angles
} sim_switch_edges_t;

typedef struct {
    sim_switch_window_t window;
    bool is_on; ///< the output
    struct {
        double at_s;
        bool is_on;
    } pending[sim_switches_pending]; ///< ring of changes that have not taken effect
    uint32_t first, n_pending;
    sim_switch_edges_t off, on;
    double low_mm, high_mm; ///< range of heights where it was on
} sim_switch_t;

/// Zero-initialised: no switch in use.
typedef struct {
    double t_s, turn; ///< of the last tick
    uint32_t n_used;  ///< switches from the first to the last one in use
    sim_switch_t each[sim_switches_n];
} sim_switches_t;

void sim_switches_init(sim_switches_t *s, const sim_switch_window_t *window);

/// Take one tick.
/// @param t_s   [s] time at which the outputs change
/// @param turn  [turn] true drawing's angle then, not wrapped
/// @param z_mm  true height
/// @param bits  bit i: output i is on from now on
void sim_switches_tick(sim_switches_t *s, double t_s, double turn, double z_mm, uint32_t bits);

#endif
