// SPDX-License-Identifier: Apache-2.0
/// learn_plant: a machine on which learning is tried a thousand times: U with dead time, friction,
/// a mode and a scale, in floating point, and the interrupt's part of learning at a known angle.
///
///     command   u(a + lead) + k1 u' + k2 u'' + c(a)          what cam_tick writes, MATHS.md (56)
///     U         y'' = w^2 (command(t - D) - y) - 2 d w y' - f sat(y' / v_s) + disturbance
///     mode      q'' = -w_m^2 q - 2 d_m w_m q' - y'',  measured y + share q
///     scale     measured(t - L), rounded to the quantum
///
/// It has nothing in common with the simulator but the equations. Integrated by 4 semi-implicit
/// steps per tick.
#ifndef LEARN_PLANT_H
#define LEARN_PLANT_H

#include "cam_learning.h"
#include <stdint.h>

enum { learn_ring = 256 };

typedef struct {
    double bandwidth_hz, damping, delay_us; ///< of the drive
    double friction_mm_s2;                  ///< [mm/s^2]
    double mode_hz, mode_damping, mode_share;
    double latency_us; ///< of the scale, not known to the controller
    double quantum_um;
    double push_mm_s2; ///< constant disturbance
} learn_drive_t;

typedef struct {
    learn_drive_t truth, believed;
    double amplitude_mm[5]; ///< cosine of harmonic 0 .. 4 of the shape
    double rpm;
    double growth_per_turn; ///< of the amplitude, share of the first
    uint32_t tick_hz;
    uint32_t polls_per_tick_q4; ///< 16: one poll per tick
    uint32_t slow_turns;        ///< the slow side takes a turn only every so many turns
} learn_case_t;

typedef struct {
    learn_case_t what;
    cam_ilc_t ilc;
    cam_ilc_setup_t setup;
    cam_turn_bins_t bins;
    cam_learned_t learned;
    cam_state_t state;
    double y, v, q, p; ///< mm, mm/s: U and its mode
    double command[learn_ring];
    double set[learn_ring]; ///< nm
    double shown[learn_ring];
    int64_t pos_q32;
    uint64_t tick;
    uint32_t generation;
    double scale;                     ///< amplitude at present
    int32_t phase_q32;                ///< that the operator has set; the shape itself stays
    double turn_square, turn_most_um; ///< of the turn that runs
    uint32_t turn_ticks;
    double rms_um, most_um; ///< of the last whole turn: true U against what was due
} learn_plant_t;

/// Everything at rest, nothing learned.
void learn_plant_init(learn_plant_t *p, const learn_case_t *what);

/// Play whole turns in a state.
void learn_plant_turns(learn_plant_t *p, cam_state_t state, uint32_t n_turns);

#endif
