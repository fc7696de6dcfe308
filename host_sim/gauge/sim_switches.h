// SPDX-License-Identifier: Apache-2.0
/// sim_switches: where the position switches really act, against the windows that were asked for.
///
/// Behind each output is a thing that acts its dead time after the output changes. The true angle
/// of the spindle at that instant, between two ticks by a straight line, is compared with the ends
/// of the window. A change that lies farther from the end than an eighth of the distance from
/// window to window has another cause than the angle: the height, a state, the sense of rotation.
/// It is counted by itself.
#ifndef SIM_SWITCHES_H
#define SIM_SWITCHES_H

#include <stdbool.h> // bool
#include <stdint.h>  // uint32_t

enum { sim_switches_n = 8, sim_switches_pending = 64 };

/// What was asked for.
typedef struct {
    double per_turn; ///< 0: the switch is not in use
    double on_turn, off_turn;
    double dead_time_s;
} sim_switch_window_t;

/// Changes of one sense: on, or off.
typedef struct {
    uint32_t n;                    ///< at the end of the window
    uint32_t n_other;              ///< elsewhere
    double sum_turn, largest_turn; ///< deviation from the end, above 0 in the rising angle
} sim_switch_edges_t;

typedef struct {
    sim_switch_window_t window;
    bool is_on; ///< the output
    struct {
        double at_s;
        bool is_on;
    } pending[sim_switches_pending]; ///< a ring: changes that have not acted yet
    uint32_t first, n_pending;
    sim_switch_edges_t off, on;
    double low_mm, high_mm; ///< heights at which it was on
} sim_switch_t;

/// Zero-initialised no switch is in use.
typedef struct {
    double t_s, turn; ///< of the last tick
    sim_switch_t each[sim_switches_n];
} sim_switches_t;

void sim_switches_init(sim_switches_t *s, const sim_switch_window_t *window);

/// Take one tick.
/// @param t_s   [s] instant of the outputs' change
/// @param turn  [turn] true angle then, by the drawing, not wrapped
/// @param z_mm  true height
/// @param bits  bit i: output i is on from now on
void sim_switches_tick(sim_switches_t *s, double t_s, double turn, double z_mm, uint32_t bits);

#endif
