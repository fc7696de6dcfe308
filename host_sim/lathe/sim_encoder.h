// SPDX-License-Identifier: Apache-2.0
/// sim_encoder: an incremental encoder with an index on the spindle.
///
///     counts = start + floor(sign (N turn + e sin(2 pi (turn - p))) + jitter)
///
/// N counts per turn, eccentricity e in counts (a disc off centre by d on a track of radius R
/// shifts by e = N d / (2 pi R)), p the angle without error, jitter bell-shaped noise of the edges.
/// The index lies at a fixed angle; crossing it latches the counter where the edge is, so both
/// senses of rotation latch the same number (modulo a turn), as hal.h demands. The jitter moves the
/// latch too.
///
/// With time stamps the age of the last edge that counted is known: the angle of the edge follows
/// from the equation above, its time from the way of the spindle between two readings, taken as the
/// cubic through angles and speeds at both, MATHS.md (129). That is right to 1e-9 s at 2500 r/min
/// and 0.2 % of ripple. An edge before the last reading keeps its time.
#ifndef SIM_ENCODER_H
#define SIM_ENCODER_H

#include "hal/hal.h"    // hal_encoder_t
#include "sim_random.h" // sim_random_t
#include <stdint.h>     // int64_t

typedef struct {
    double counts_per_turn;     ///< whole number
    double sign;                ///< -1: counts fall in the machine's positive sense
    double index_turn;          ///< [turn] place of the index
    double eccentricity_counts; ///< [counts] amplitude of the error once per turn
    double eccentricity_turn;   ///< [turn] angle of no error, where it rises
    double jitter_counts;       ///< [counts] rms
    double start_counts; ///< counter at angle 0, a whole number; chosen so that the counter wraps
                         ///< during a cut
    double has_time_stamps; ///< 1: hardware stamps the edges
} sim_encoder_config_t;

/// 10 000 counts per turn, no eccentricity, no jitter, index at 0.3 turn; the counter wraps after
/// 50 turns.
sim_encoder_config_t sim_encoder_defaults(void);

typedef struct {
    sim_encoder_config_t config;
    sim_random_t random;
    int64_t index_counts; ///< place of the index edge inside the turn
    int64_t n_turns;      ///< index edges below the present angle
    hal_encoder_t reading;
    // with time stamps
    int64_t counts;                 ///< of the last reading, before it wraps
    double jitter_counts;           ///< in it
    int64_t stamped_counts;         ///< of the last stamp
    double turn, speed_turns_per_s; ///< there
    double edge_age_s;              ///< [s] from the last edge that counted to the last reading
} sim_encoder_t;

/// @param turn  [turn] angle of the spindle now
/// @param seed  of the jitter
void sim_encoder_init(sim_encoder_t *e, const sim_encoder_config_t *config, double turn,
                      uint64_t seed);

/// Take a reading. At most one turn may pass between two readings.
/// @param turn  [turn] true angle of the spindle, not wrapped
hal_encoder_t sim_encoder_read(sim_encoder_t *e, double turn);

/// Find the age of the last edge that counted, after a reading: e->edge_age_s. Without time stamps
/// nothing is done.
/// @param turn               [turn] of the reading
/// @param speed_turns_per_s  there
/// @param dt_s               since the last call
void sim_encoder_stamp(sim_encoder_t *e, double turn, double speed_turns_per_s, double dt_s);

#endif
