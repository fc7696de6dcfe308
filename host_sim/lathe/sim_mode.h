// SPDX-License-Identifier: Apache-2.0
/// sim_mode: a flexible mode between the slide of U and the tip of its tool.
///
///     d2q/dt2 + 2 d w dq/dt + w^2 q = -share d2x/dt2          tip = x + q
///
/// x is the slide, q what the tip moves against it. Slow motion gives q = -share a / w^2. A mode
/// that lies on the scale is measured by the scale, one that does not lies between scale and tip.
/// It does not push back: the mass of the mode is taken to be a part of the slide's. Source:
/// MATHS.md (123); a base-excited oscillator, e.g. Preumont, "Vibration Control of Active
/// Structures", 3rd ed., 2.2.
///
/// Discretisation: with y = x + q / share the equation is driven by x and dx/dt, which are taken as
/// the cubic through positions and speeds at both ends of a piece; for a cubic the flow is exact. A
/// jump J of the acceleration inside a piece of length T makes x wrong by less than J T^2 / 64
/// within it, 1 nm at 20 m/s2 and 50 us, and q by less than that; a smooth x by T^4 x'''' / 384.
#ifndef SIM_MODE_H
#define SIM_MODE_H

#include <stdbool.h> // bool

enum { sim_mode_n = 2 }; ///< modes of a machine

typedef struct {
    double hz;          ///< w / 2 pi; 0: there is no such mode
    double damping;     ///< d
    double share;       ///< of the slide's acceleration that moves the tip; below 0: forwards
    double is_on_scale; ///< 1: the scale sees it; 0: it lies between scale and tip
} sim_mode_config_t;

typedef struct {
    double omega_rad_per_s, damping, share;
    bool is_on_scale;
    double pos_micro, vel_micro_per_s; ///< y - x, what the tip would move with a share of 1
} sim_mode_t;

/// The slide at the two ends of a piece.
typedef struct {
    double pos_micro[2], vel_micro_per_s[2];
} sim_mode_way_t;

/// @return none, which moves nothing; damping 0.03 and share 1 for a mode that is given a frequency
sim_mode_config_t sim_mode_defaults(void);

/// At rest.
void sim_mode_init(sim_mode_t *m, const sim_mode_config_t *config);

/// Let a piece pass in which the slide moved.
/// @param dt_s  >= 0
void sim_mode_step(sim_mode_t *m, const sim_mode_way_t *way, double dt_s);

/// @return [micro] what the tip has moved against the slide
double sim_mode_tip_micro(const sim_mode_t *m);

#endif
