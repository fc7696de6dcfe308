// SPDX-License-Identifier: Apache-2.0
/// lin_load: worst-case bus load of a configuration.
///
/// Frames have the greatest number of stuff bits; encoder and drives send one frame per tick, each
/// node two heartbeats per node_timeout_ms. Retransmissions and frames of other nodes are not
/// counted. Pure. Source: ISO 11898-1, frame formats; a stuff bit after five equal bits.
#ifndef LIN_LOAD_H
#define LIN_LOAD_H

#include "lin_config.h" // lin_config_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int64_t

typedef struct {
    int64_t tick_ns;   ///< bus time of the frames of one tick
    int64_t second_ns; ///< bus time of heartbeats and status in a second
    int64_t n_queued;  ///< [frames] most that this computer sends in one tick
} lin_load_t;

lin_load_t lin_load_of(const lin_config_t *config);

/// @return [%] bus load, rounded up
int64_t lin_load_percent(const lin_load_t *load, int64_t tick_hz);

/// @return [Hz] highest tick rate possible, 0: none
int64_t lin_load_most_hz(const lin_load_t *load);

#endif
