// SPDX-License-Identifier: Apache-2.0
/// sim_encoder: the spindle's incremental encoder, with index.
///
///     counts = start + floor(sign (N turn + e sin(2 pi (turn - p))) + jitter)
///
/// N counts per turn, eccentricity e in counts (a disc off centre by d on a track of radius R
/// shifts by e = N d / (2 pi R)), p the angle without error, jitter bell-shaped noise of the edges.
/// The index has a fixed angle; crossing it latches the counter at the edge, so both senses of
/// rotation latch the same number (modulo a turn), as hal.h demands. The jitter also moves the
/// latch.
///
/// Time stamps give the age of the last edge that counted: the angle of the edge follows from the
/// equation above, its time from the cubic through angles and speeds at two readings, MATHS.md
/// (129), within 1e-9 s at 2500 r/min and 0.2 % of ripple. An edge before the last reading keeps
/// its time.
#ifndef SIM_ENCODER_H
#define SIM_ENCODER_H

#include "hal/hal.h"    // hal_encoder_t
#include "sim_random.h" // sim_random_t
#include <stdint.h>     // int64_t

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

/// 10 000 counts per turn, no eccentricity, no jitter, index at 0.3 turn; the counter wraps after
/// 50 turns.
sim_encoder_config_t sim_encoder_defaults(void);

typedef struct {
    sim_encoder_config_t config;
    sim_random_t random;
    int64_t index_counts; ///< position of the index edge within the turn
    int64_t n_turns;      ///< number of index edges below the present angle
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

#endif
