// SPDX-License-Identifier: Apache-2.0
/// lcn_index: index edges from the two counters of a HAL encoder.
///
/// A HAL encoder does not report the position of the index. It has a counter that is never reset
/// (`rawcounts`) and one that is reset by the next index edge after `index-enable` is set
/// (`counts`); so raw - counts is the position of the last edge that was waited for.
///
/// If only camturn uses the encoder, it waits for every edge, and the firmware detects lost counts
/// within a turn. If LinuxCNC counts turns with the same encoder (G33, G76), a reset in every turn
/// would disturb it. Then camturn waits for one edge after enable and reports calculated edges, one
/// per turn; edges that LinuxCNC waits for are reported and checked in addition.
#ifndef LCN_INDEX_H
#define LCN_INDEX_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, uint32_t

/// Pins of a HAL encoder.
typedef struct {
    int32_t raw;    ///< [counts] never reset
    int32_t counts; ///< [counts] since the last edge with index-enable set
    bool is_armed;  ///< index-enable is set
    bool is_shared; ///< LinuxCNC counts turns with the same encoder
} lcn_counters_t;

/// State; initially zero.
typedef struct {
    bool is_started; ///< the first reading was processed
    bool is_known;   ///< an edge was detected since enable
    bool arms;       ///< result: set index-enable
    uint32_t latch;  ///< [counts] raw - counts of the last tick
    uint32_t counts; ///< [counts] result: position of the last edge
    uint32_t n;      ///< result: number of edges
} lcn_index_t;

/// Process the reading of a tick.
/// @param turn_counts  [counts] per turn, > 0
/// @param is_off       the drives are disabled; the index must be found again
/// Context: fast thread, constant time.
void lcn_index_step(lcn_index_t *x, const lcn_counters_t *now, int32_t turn_counts, bool is_off);

#endif
