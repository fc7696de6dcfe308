// SPDX-License-Identifier: Apache-2.0
/// sim_friction: a slide with stick-slip, driven by a drive and disturbed by a force.
///
///     d2x/dt2 = clamp(p - K x - D v, -A, A) + a - f sgn(v)       while it moves
///     v = 0 and stays 0                                          while |p - K x + a| <= f
///     dp/dt = (input - p) / tau, or p = input where tau = 0
///
/// K and D belong to a position loop (w^2, 2 d w; the input is w^2 times the command) or to the
/// guide of a free mass (spring and drag per mass; the input is force per mass). f is the Coulomb
/// friction per mass, the same at rest and in motion. Source: MATHS.md (121), (122); Coulomb's law
/// as in Armstrong-Helouvry, Dupont, Canudas de Wit, "A survey of models, analysis tools and
/// compensation methods for the control of machines with friction", Automatica 30(7), 1994.
///
/// Beyond a stop, its spring and a damper of half the critical damping push the slide back.
///
/// The sign function is not regularised: a reversal is located to 2^-40 of a sub-step. The slide
/// rests there and moves again only when the push exceeds the friction, so sticking is true rest.
///
/// Discretisation: classical fourth-order Runge-Kutta, at least 4 sub-steps in a piece of constant
/// input, none longer than a quarter of the fastest time constant. With 300 Hz, damping 0.7 and 20
/// kHz the relative error of the travel is below 5e-9 where the sign of v does not change;
/// breakaway is found to a sub-step, 6 us, during which the net push grows from zero. Compared with
/// an event-driven solution of scipy at 20 m/s2 and 100 Hz the error is below 0.05 nm
/// (tests/tools/sim/test_slide.py). At the limits of acceleration (A) and speed the error is of
/// second order in the sub-step.
#ifndef SIM_FRICTION_H
#define SIM_FRICTION_H

/// Units: micro and seconds, as in sim_drive.h.
typedef struct {
    double stiffness_per_s2;          ///< K
    double drag_per_s;                ///< D
    double acceleration_micro_per_s2; ///< A, > 0
    double speed_micro_per_s;         ///< limit of |v|, > 0
    double friction_micro_per_s2;     ///< f
    double lag_per_s;                 ///< 1 / tau, 0: none
    double stop_micro;                ///< stops at this distance from 0, either side; 0: none
    double stop_per_s2;               ///< their stiffness per mass, > 0
    double longest_s;                 ///< longest sub-step, see sim_friction_longest_s()
} sim_friction_law_t;

typedef struct {
    double pos_micro;
    double vel_micro_per_s;
    double push_micro_per_s2; ///< p
} sim_friction_state_t;

/// @return [s] longest sub-step allowed by the constants of a law; does not read law->longest_s
double sim_friction_longest_s(const sim_friction_law_t *law);

/// Advance with a constant input.
/// @param input_micro_per_s2    input of the push
/// @param disturb_micro_per_s2  a, constant
/// @param time_s                >= 0
void sim_friction_move(const sim_friction_law_t *law, sim_friction_state_t *s,
                       double input_micro_per_s2, double disturb_micro_per_s2, double time_s);

#endif
