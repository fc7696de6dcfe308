// SPDX-License-Identifier: Apache-2.0
/// sim_servo: the position loop of a force drive, which makes it act as a position drive.
///
///     F = Kp (c - y) + Ki sum (c - y) T - Kd v,       |F| <= limit
///     Kp = m w^2,  Kd = 2 d m w - b,  Ki = Kp w / 200
///
/// c is the command, y the reading of the scale, v its difference over a period after a first-order
/// filter at 8 w; m is the mass for which the loop is tuned, b the viscous drag. The integral is
/// held while the force is at its limit. The force is updated once per period T and acts after the
/// dead time D through a first-order amplifier, tau = 1 / (2 pi amplifier_hz), on the slide of
/// sim_friction.h:
///
///     m x'' = F - b x' - k x - friction - cutting force
///
/// Source: MATHS.md (126), (127); PID with the derivative of the measurement, e.g. Astrom, Murray,
/// "Feedback Systems", 2nd ed., 11.
///
/// The equivalent position drive: e^(jwL) (1 + k1 jw + k2 (jw)^2) is fitted to the inverse of the
/// closed loop's frequency response over 20 Hz .. w by least squares, the dead time L by a search
/// in steps of 5 us up to 2 ms. Holding the force for T counts as a dead time of T / 2, with an
/// error of (w T)^2 / 24.
#ifndef SIM_SERVO_H
#define SIM_SERVO_H

#include "sim_drive_config.h" // sim_drive_config_t
#include <stdbool.h>          // bool

typedef struct {
    double kp_per_s2, kd_per_s, ki_per_s3; ///< per mass: accelerations
    double filter;                         ///< weight of a new difference in the filtered speed
    double limit_micro_per_s2;
    double period_s;
    // state
    bool is_running; ///< false: the next call restarts the loop
    double last_micro, speed_micro_per_s, sum_micro_per_s2;
} sim_servo_t;

/// The loop is tuned for config->tuned_mass_kg and moves config->mass_kg.
/// @param period_s  T
void sim_servo_init(sim_servo_t *s, const sim_drive_config_t *config, double period_s);

/// Process a command and a reading.
/// @return [micro/s2] force per mass
double sim_servo_push(sim_servo_t *s, double command_micro, double read_micro);

/// Stop the loop while the drive is off; it restarts with the next call.
void sim_servo_rest(sim_servo_t *s);

/// The equivalent position drive.
typedef struct {
    double k1_s, k2_s2; ///< of its inverse
    double lead_s;      ///< dead time, holding included
} sim_servo_equivalent_t;

/// @param config    of kind force
/// @param period_s  T
sim_servo_equivalent_t sim_servo_equivalent(const sim_drive_config_t *config, double period_s);

#endif
