// SPDX-License-Identifier: Apache-2.0
/// sim_spindle: a driven inertia with speed ripple over the angle.
///
///     J dw/dt = clamp(J b (w_set - w), -M, M)          mean speed w, speed loop of bandwidth b
///     dturn/dt = w (1 + sum r sin(2 pi k turn)) / (2 pi)   kinematic ripple: belt, motor poles
///
/// Discretisation: w is exact (an exponential, or a ramp while the torque is at its limit); the
/// angle is integrated by the trapezium rule with an error below b^2 |w_set - w| T^3 / 12 per step,
/// 5e-12 turn in a run-up with the defaults. The ripple is integrated by the midpoint rule: the
/// relative error of the speed is r (k w T)^2 / 24, 6e-8 at 2500 r/min and 20 kHz. Both errors only
/// make a slightly different spindle: encoder and gauge use the resulting angle. Source: MATHS.md
/// (69), (128).
#ifndef SIM_SPINDLE_H
#define SIM_SPINDLE_H

typedef struct {
    double inertia_kgm2;        ///< spindle, chuck and part
    double torque_Nm;           ///< largest torque, both senses
    double bandwidth_rad_per_s; ///< of the speed loop
    double ripple;              ///< amplitude of the ripple, share of the speed
    double ripple_per_turn;     ///< periods per turn
    double ripple_2;            ///< amplitude of a second ripple; 0: none
    double ripple_per_turn_2;   ///< its periods per turn
    double start_turn;          ///< [turn] angle at rest before the start
} sim_spindle_config_t;

/// 0.1 kg m2 and 50 Nm (500 rad/s2), 40 rad/s, 0.2 % twice per turn, no second ripple.
sim_spindle_config_t sim_spindle_defaults(void);

typedef struct {
    double turn;             ///< [turn] true angle, signed, not wrapped
    double speed_rad_per_s;  ///< mean speed, signed, without the ripple
    double limit_rad_per_s2; ///< torque / inertia
    double bandwidth_rad_per_s;
    double ripple, ripple_per_turn, ripple_2, ripple_per_turn_2;
} sim_spindle_t;

void sim_spindle_init(sim_spindle_t *s, const sim_spindle_config_t *config);

/// Advance the time.
/// @param set_rad_per_s  commanded speed, signed
/// @param dt_s           >= 0
void sim_spindle_step(sim_spindle_t *s, double set_rad_per_s, double dt_s);

/// @return [rad/s] present speed with the ripple
double sim_spindle_true_rad_per_s(const sim_spindle_t *s);

#endif
