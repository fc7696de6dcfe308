// SPDX-License-Identifier: Apache-2.0
/// sim_encoder: the spindle's incremental encoder, with index.
///
///     counts = start + floor(sign (N turn + e sin(2 pi (turn - p))) + i + jitter)
///
/// N counts per turn, eccentricity e in counts (a disc off centre by d on a track of radius R
/// shifts by e = N d / (2 pi R)), p the angle without error, jitter bell-shaped noise of the edges.
/// The index has a fixed angle and, as a gated index pulse has, lies on the edge of a count: i, at
/// most half a count, puts an edge there. Crossing it latches the counter at the edge, so both
/// senses of rotation latch the same number (modulo a turn), as hal.h demands. The jitter also
/// moves the latch.
///
/// Time stamps give the age of the last edge that counted: the angle of the edge follows from the
/// equation above, its time from the cubic through angles and speeds at two readings, MATHS.md
/// (129), within 1e-9 s at 2500 r/min and 0.2 % of ripple. An edge before the last reading keeps
/// its time.
#ifndef SIM_ENCODER_H
#define SIM_ENCODER_H

#include "hal/hal.h"    // hal_encoder_t
#include "sim_random.h" // sim_random_t
#include <stdint.h>     // int64_t, uint32_t

// A driven inertia with speed ripple over the angle.
//
//     J dw/dt = clamp(J b (w_set - w), -M, M)          mean speed w, speed loop of bandwidth b
//     dturn/dt = w (1 + sum r sin(2 pi k turn)) / (2 pi)   kinematic ripple: belt, motor poles
//
// Discretisation: w is exact (an exponential, or a ramp while the torque is at its limit); the
// angle is integrated by the trapezium rule with an error below b^2 |w_set - w| T^3 / 12 per step,
// 5e-12 turn in a run-up with the defaults. The ripple is integrated by the midpoint rule: the
// relative error of the speed is r (k w T)^2 / 24, 6e-8 at 2500 r/min and 20 kHz. Both errors only
// make a slightly different spindle: encoder and gauge use the resulting angle. Source: MATHS.md
// (69), (128).

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

// The encoder

typedef struct {
    double counts_per_turn;     ///< whole number
    double sign;                ///< -1: counts fall in the machine's positive sense
    double index_turn;          ///< [turn] angle of the index
    double eccentricity_counts; ///< [counts] amplitude of the error once per turn
    double eccentricity_turn;   ///< [turn] angle where the error is zero and rises
    double jitter_counts;       ///< [counts] rms
    double start_counts; ///< counter at angle 0, a whole number; the default makes the counter wrap
                         ///< during a cut
    double has_time_stamps; ///< 1: hardware stamps the edges
} sim_encoder_config_t;

typedef struct {
    sim_encoder_config_t config;
    sim_random_t random;
    int64_t index_counts;    ///< position of the index edge within the turn
    double index_counts_off; ///< [counts] by which the counts are shifted so that it is on an edge
    int64_t n_turns;         ///< number of index edges below the present angle
    hal_encoder_t reading;
    // with time stamps
    int64_t counts;                 ///< last reading, not wrapped
    double jitter_counts;           ///< jitter of that reading
    int64_t stamped_counts;         ///< counts at the last stamp
    double turn, speed_turns_per_s; ///< at the last stamp
    double edge_age_s;              ///< [s] from the last edge that counted to the last reading
} sim_encoder_t;

/// @param turn  [turn] angle of the spindle now
/// @param seed  seed of the jitter
void sim_encoder_init(sim_encoder_t *e, const sim_encoder_config_t *config, double turn,
                      uint64_t seed);

/// Take a reading. At most one turn may pass between two readings.
/// @param turn  [turn] true angle of the spindle, not wrapped
hal_encoder_t sim_encoder_read(sim_encoder_t *e, double turn);

/// After a reading, update e->edge_age_s. Does nothing without time stamps.
/// @param turn               [turn] angle at the reading
/// @param speed_turns_per_s  speed at the reading
/// @param dt_s               time since the last call
void sim_encoder_stamp(sim_encoder_t *e, double turn, double speed_turns_per_s, double dt_s);

// The linear scale of U: latency, interpolation error, quantum.
//
//     reading = round((y(t - L) + e sin(4 pi y / P)) / quantum) quantum
//
// y is what the scale sees, L the time by which it latches before the encoder, e the interpolation
// error, which repeats twice in a period P of the scale when the gains of its sine and cosine
// differ. Source: MATHS.md (124); Heydemann, "Determination and correction of quadrature fringe
// measurement errors in interferometers", Applied Optics 20(19), 1981.
//
// Between two steps y is the cubic through positions and speeds at both. Its error is T^4 y'''' /
// 384, below 0.01 nm for 300 Hz and 20 kHz, and J T^2 / 64 where the acceleration jumps by J.

enum { sim_scale_ring = 256 }; ///< steps kept: 1000 us at 200 000 steps per second

typedef struct {
    double latency_us; ///< L
    double error_nm;   ///< e
    double period_um;  ///< P
} sim_scale_config_t;

typedef struct {
    double latency_steps;
    double error_micro, periods_per_micro; ///< e, 2 / P
    double step_s;
    uint32_t i;
    double pos_micro[sim_scale_ring], vel_micro_per_s[sim_scale_ring];
} sim_scale_t;

/// @param pos_micro  position at rest before the start
/// @param step_s     between calls of sim_scale_push(); latency / step_s < sim_scale_ring - 1
void sim_scale_init(sim_scale_t *s, const sim_scale_config_t *config, double pos_micro,
                    double step_s);

/// Add the state after a step.
void sim_scale_push(sim_scale_t *s, double pos_micro, double vel_micro_per_s);

/// @return [micro] reading before rounding to the quantum
double sim_scale_read_micro(const sim_scale_t *s);

#endif
