// SPDX-License-Identifier: Apache-2.0
/// sim_scale: the linear scale of U: latency, interpolation error, quantum.
///
///     reading = round((y(t - L) + e sin(4 pi y / P)) / quantum) quantum
///
/// y is what the scale sees, L the time by which it latches before the encoder, e the interpolation
/// error, which repeats twice in a period P of the scale when the gains of its sine and cosine
/// differ. Source: MATHS.md (124); Heydemann, "Determination and correction of quadrature fringe
/// measurement errors in interferometers", Applied Optics 20(19), 1981.
///
/// Between two steps y is the cubic through positions and speeds at both. Its error is T^4 y'''' /
/// 384, below 0.01 nm for 300 Hz and 20 kHz, and J T^2 / 64 where the acceleration jumps by J.
#ifndef SIM_SCALE_H
#define SIM_SCALE_H

#include <stdint.h> // uint32_t

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

/// No latency, no error; 20 um.
sim_scale_config_t sim_scale_defaults(void);

/// @param pos_micro  position at rest before the start
/// @param step_s     between calls of sim_scale_push(); latency / step_s < sim_scale_ring - 1
void sim_scale_init(sim_scale_t *s, const sim_scale_config_t *config, double pos_micro,
                    double step_s);

/// Add the state after a step.
void sim_scale_push(sim_scale_t *s, double pos_micro, double vel_micro_per_s);

/// @return [micro] reading before rounding to the quantum
double sim_scale_read_micro(const sim_scale_t *s);

#endif
