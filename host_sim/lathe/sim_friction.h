// SPDX-License-Identifier: Apache-2.0
/// sim_friction: a slide that sticks and slips, pushed by a drive and disturbed by a force.
///
///     d2x/dt2 = clamp(p - K x - D v, -A, A) + a - f sgn(v)       while it moves
///     v = 0 and stays 0                                          while |p - K x + a| <= f
///     dp/dt = (input - p) / tau, or p = input where tau = 0
///
/// K and D are those of a position loop (w^2, 2 d w; the input is w^2 times the command) or of the
/// guide of a free mass (spring and drag by mass; the input is force by mass). f is the Coulomb
/// friction by mass, the same in rest and in motion. Source: MATHS.md (121), (122); Coulomb's law
/// as in Armstrong-Helouvry, Dupont, Canudas de Wit, "A survey of models, analysis tools and
/// compensation methods for the control of machines with friction", Automatica 30(7), 1994.
///
/// The sign function is not regularised: a reversal is found to 2^-40 of a sub-step, the slide is
/// at rest there, and it goes on only when the push is stronger than the friction. Sticking is
/// therefore true rest.
///
/// Discretisation: classical Runge-Kutta of fourth order, at least 4 sub-steps in a piece of
/// constant input and so many that none is longer than a quarter of the fastest time constant. With
/// 300 Hz, damping 0.7 and 20 kHz the way is off by less than 5e-9 of itself where the sign of v
/// stays; the moment of breaking loose is found to a sub-step, 6 us, during which the push grows
/// from nothing. Measured against an event-driven solution of scipy at 20 m/s2 and 100 Hz:
/// tests/tools/sim/test_slide.py, which holds the bound of 0.05 nm. At the limits A and of the
/// speed the error is of second order in the sub-step.
#ifndef SIM_FRICTION_H
#define SIM_FRICTION_H

/// Units: micro and seconds, as in sim_drive.h.
typedef struct {
    double stiffness_per_s2;          ///< K
    double drag_per_s;                ///< D
    double acceleration_micro_per_s2; ///< A, > 0
    double speed_micro_per_s;         ///< |v| is kept below, > 0
    double friction_micro_per_s2;     ///< f
    double lag_per_s;                 ///< 1 / tau, 0: none
    double longest_s;                 ///< longest sub-step, see sim_friction_longest_s()
} sim_friction_law_t;

typedef struct {
    double pos_micro;
    double vel_micro_per_s;
    double push_micro_per_s2; ///< p
} sim_friction_state_t;

/// @return [s] longest sub-step that the constants of a law allow; its own longest_s is not read
double sim_friction_longest_s(const sim_friction_law_t *law);

/// Let time pass with a constant input.
/// @param input_micro_per_s2    what the push follows
/// @param disturb_micro_per_s2  a, constant
/// @param time_s                >= 0
void sim_friction_move(const sim_friction_law_t *law, sim_friction_state_t *s,
                       double input_micro_per_s2, double disturb_micro_per_s2, double time_s);

#endif
