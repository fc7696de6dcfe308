// SPDX-License-Identifier: Apache-2.0
/// sim_mode: a flexible mode between the slide of U and the tip of its tool.
///
///     d2q/dt2 + 2 d w dq/dt + w^2 q = -share d2x/dt2          tip = x + q
///
/// x is the position of the slide, q that of the tip relative to it. For slow motion q = -share a /
/// w^2. The scale measures a mode that is on the scale; any other is between scale and tip. The
/// mode does not push back: its mass counts as part of the slide's. Source: MATHS.md (123); a
/// base-excited oscillator, e.g. Preumont, "Vibration Control of Active Structures", 3rd ed., 2.2.
///
/// Discretisation: with y = x + q / share the equation is driven by x and dx/dt. x is the cubic
/// through positions and speeds at both ends of a piece; for a cubic the flow is exact. A jump J of
/// the acceleration inside a piece of length T causes an error of x below J T^2 / 64, 1 nm at 20
/// m/s2 and 50 us, and a smaller error of q; for a smooth x the error is T^4 x'''' / 384.
#ifndef SIM_MODE_H
#define SIM_MODE_H

#include <stdbool.h> // bool

enum { sim_mode_n = 2 }; ///< modes of a machine

typedef struct {
    double hz;          ///< w / 2 pi; 0: no mode
    double damping;     ///< d
    double share;       ///< share of the slide's acceleration that moves the tip; below 0: forwards
    double is_on_scale; ///< 1: the scale measures it; 0: it is between scale and tip
} sim_mode_config_t;

typedef struct {
    double omega_rad_per_s, damping, share;
    bool is_on_scale;
    double pos_micro, vel_micro_per_s; ///< y - x: motion of the tip for a share of 1
} sim_mode_t;

/// Motion of the slide over a piece: state at both ends.
typedef struct {
    double pos_micro[2], vel_micro_per_s[2];
} sim_mode_travel_t;

/// @return no mode (0 Hz), with damping 0.03 and share 1
sim_mode_config_t sim_mode_defaults(void);

/// Start at rest.
void sim_mode_init(sim_mode_t *m, const sim_mode_config_t *config);

/// Advance over a piece of the slide's motion.
/// @param dt_s  >= 0
void sim_mode_step(sim_mode_t *m, const sim_mode_travel_t *travel, double dt_s);

/// @return [micro] position of the tip relative to the slide
double sim_mode_tip_micro(const sim_mode_t *m);

#endif
