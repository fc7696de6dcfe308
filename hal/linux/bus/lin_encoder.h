// SPDX-License-Identifier: Apache-2.0
/// lin_encoder: positions that arrive in frames become a counter that can be read at any instant.
///
///     frame   before        last                  tick
///     -----------+------------+---------------------+----> time        counts(tick) =
///             b counts     c counts            extrapolated            c + (c - b) / dt * age
///
/// Positions are unwrapped to 64 bits. The index is either an edge of a line, whose time stamp is
/// turned into counts between the two frames around it, or a fixed value of the position itself.
/// Pure; one thread. Times are ns of one clock.
#ifndef LIN_ENCODER_H
#define LIN_ENCODER_H

#include "hal/hal.h"    // hal_encoder_t
#include "lin_config.h" // lin_encoder_config_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int64_t, uint32_t

typedef struct {
    lin_encoder_config_t config;
    int64_t least_ns; ///< no speed is measured between frames that are closer together
    bool has_frame;
    uint32_t raw;              ///< position as it arrived
    int64_t counts, ns;        ///< newest position and its time
    int64_t before, before_ns; ///< earlier one, at least least_ns apart; the same at first
    int64_t mark, mark_ns;     ///< between them: the next `before` once it is least_ns old
    int64_t index_counts;
    uint32_t n_index;
    int64_t edge_ns;
    bool is_edge_open; ///< the edge waits for the frame behind it
} lin_encoder_t;

/// @param tick_hz  approximate rate at which frames are expected
void lin_encoder_init(lin_encoder_t *e, const lin_encoder_config_t *config, int64_t tick_hz);

/// Take a position that arrived.
/// @param raw  below config.modulus_counts; any when that is 0
/// @param ns   arrival of the frame; delay_ns is taken off here
void lin_encoder_take(lin_encoder_t *e, uint32_t raw, int64_t ns);

/// Take an edge of the index line. Of the two edges of a pulse the one that a positive rotation
/// passes first counts: rising in positive, falling in negative sense. Ignored with
/// lin_index_position.
void lin_encoder_edge(lin_encoder_t *e, int64_t ns, bool is_rising);

/// @return the counter at an instant; beyond max_age_us behind the newest frame it stands still
hal_encoder_t lin_encoder_at(const lin_encoder_t *e, int64_t ns);

/// @return whether the newest frame is not older than max_age_us
bool lin_encoder_is_fresh(const lin_encoder_t *e, int64_t ns);

#endif
