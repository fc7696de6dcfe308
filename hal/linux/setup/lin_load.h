// SPDX-License-Identifier: Apache-2.0
/// lin_load: the load that a configuration puts on its bus.
///
/// Every frame is counted with the most stuff bits that it can have, the encoder and each drive
/// with one frame a tick, each node with two heartbeats in node_timeout_ms. Repetitions after
/// errors and the frames of others are not counted. Pure. Source: ISO 11898-1, frame formats; stuff
/// bits after each five equal ones.
#ifndef LIN_LOAD_H
#define LIN_LOAD_H

#include "lin_config.h" // lin_config_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int64_t

typedef struct {
    int64_t tick_ns;   ///< bus time of the frames of one tick
    int64_t second_ns; ///< bus time of heartbeats and status in a second
    int64_t n_queued;  ///< [frames] that this computer sends in one tick at most, without
                       ///< answers
} lin_load_t;

lin_load_t lin_load_of(const lin_config_t *config);

/// @return [%] of the bus, rounded up
int64_t lin_load_percent(const lin_load_t *load, int64_t tick_hz);

/// @return [Hz] highest tick rate that the bus bears, 0: none
int64_t lin_load_most_hz(const lin_load_t *load);

#endif
