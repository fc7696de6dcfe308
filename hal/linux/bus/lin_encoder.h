// SPDX-License-Identifier: Apache-2.0
/// lin_encoder: turns encoder positions from frames into a counter that can be read at any instant.
///
///     frame   before        last                  tick
///     -----------+------------+---------------------+----> time        counts(tick) =
///             b counts     c counts            extrapolated            c + (c - b) / dt * age
///
/// Positions are unwrapped to 64 bits. The index is either an edge on a GPIO line, whose time stamp
/// is interpolated between the two adjacent frames, or a fixed value of the position. Pure; not
/// thread-safe. Times are ns of one clock.
#ifndef LIN_ENCODER_H
#define LIN_ENCODER_H

#include "hal/hal.h"    // hal_encoder_t
#include "lin_config.h" // lin_encoder_config_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int64_t, uint32_t

typedef struct {
    lin_encoder_config_t config;
    int64_t least_ns; ///< least time between two frames for a speed measurement
    bool has_frame;
    uint32_t raw;              ///< last received position
    int64_t counts, ns;        ///< newest position and its time
    int64_t before, before_ns; ///< base of the speed, at least least_ns earlier; initially the same
    int64_t mark, mark_ns;     ///< the next `before`, once it is least_ns old
    int64_t index_counts;
    uint32_t n_index;
    int64_t edge_ns;
    bool is_edge_open; ///< the edge waits for the next frame
} lin_encoder_t;

/// @param tick_hz  [Hz] expected rate of frames
void lin_encoder_init(lin_encoder_t *e, const lin_encoder_config_t *config, int64_t tick_hz);

/// Process a received position.
/// @param raw  below config.modulus_counts; any value if that is 0
/// @param ns   arrival of the frame; delay_ns is subtracted here
void lin_encoder_receive(lin_encoder_t *e, uint32_t raw, int64_t ns);

/// Process an edge of the index line. The index is the edge of the pulse that comes first in
/// positive rotation: rising in positive, falling in negative rotation. Ignored with
/// lin_index_position.
void lin_encoder_edge(lin_encoder_t *e, int64_t ns, bool is_rising);

/// @return the counter at an instant, extrapolated by at most max_age_us
hal_encoder_t lin_encoder_at(const lin_encoder_t *e, int64_t ns);

/// @return whether the newest frame is not older than max_age_us
bool lin_encoder_is_fresh(const lin_encoder_t *e, int64_t ns);

#endif
