// SPDX-License-Identifier: Apache-2.0
/// fixture_encoder: an incremental encoder with one index mark, exact for every number of lines.
///
/// Position is real-valued counts in the raw sense; the counter is its floor. An index edge lies on
/// a boundary of counts and has the same number in both senses, as hal.h demands.
#ifndef FIXTURE_ENCODER_H
#define FIXTURE_ENCODER_H

#include "hal/hal.h" // hal_encoder_t
#include <stdint.h>  // int64_t

typedef struct {
    int32_t counts_per_turn;
    int32_t sense;    ///< +1: counts rise with the turns given; -1: they fall
    uint32_t base;    ///< counter at position 0
    int32_t index_at; ///< [counts] raw position of one index edge
    int32_t lost;     ///< [counts] added to counter and latch from now on
    long double at;   ///< [counts] raw position
    hal_encoder_t reading;
} fixture_encoder_t;

/// Put the encoder at rest at position 0.
void fixture_encoder_init(fixture_encoder_t *e, int32_t counts_per_turn, int32_t sense,
                          uint32_t base, int32_t index_at);

/// Move by turns in the given sense. @return the new reading
hal_encoder_t fixture_encoder_move(fixture_encoder_t *e, long double turns);

/// @return [turn] true angle since some index edge, in the given sense
long double fixture_encoder_turns(const fixture_encoder_t *e);

#endif
