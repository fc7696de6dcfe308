// SPDX-License-Identifier: Apache-2.0
/// lcn_index: index edges out of the two counters of a HAL encoder.
///
/// HAL's encoders do not report where the index was. They have a counter that is never reset
/// (`rawcounts`) and one that is reset by the index edge for which `index-enable` was set
/// (`counts`); so at any time raw - counts is the place of the last edge that was waited for.
///
/// Alone, camturn waits for every edge, and the firmware sees each lost count within a turn. Where
/// LinuxCNC counts turns by the same encoder (G33, G76), a reset in every turn would spoil that:
/// then camturn waits for one edge while its drives are enabled for the first time, and reports an
/// edge in every turn at the place where it is due; edges that LinuxCNC waits for come between and
/// are checked like any other.
#ifndef LCN_INDEX_H
#define LCN_INDEX_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, uint32_t

/// What the pins of a HAL encoder say.
typedef struct {
    int32_t raw;    ///< [counts] never reset
    int32_t counts; ///< [counts] since the last edge that was waited for
    bool is_armed;  ///< an edge is waited for
    bool is_shared; ///< others count turns by the same encoder
} lcn_counters_t;

/// Zero-initialised is: nothing seen.
typedef struct {
    bool is_started; ///< a reading was taken
    bool is_known;   ///< an edge was seen since the drives were enabled
    bool arms;       ///< result: the encoder is to wait for an edge
    uint32_t latch;  ///< [counts] raw - counts of the last tick
    uint32_t counts; ///< [counts] result: place of the last edge
    uint32_t n;      ///< result: number of edges
} lcn_index_t;

/// Take the reading of a tick.
/// @param turn_counts  [counts] per turn, > 0
/// @param is_off       the drives are not enabled: the angle is to be found anew
/// Context: the fast thread, constant time.
void lcn_index_step(lcn_index_t *x, const lcn_counters_t *now, int32_t turn_counts, bool is_off);

#endif
