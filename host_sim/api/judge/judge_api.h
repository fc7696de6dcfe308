// SPDX-License-Identifier: Apache-2.0
/// judge_api: the controller's verdict on a cut, as a library for the generator of tables.
///
///     open -> set, set, ... -> demands, highest_mrpm, largest_feed_nm -> close
///
/// The rule is the firmware's own (cam_feasible.h). Each handle stands alone, so several threads
/// may each use one. A call takes microseconds, a search a few times ten of them.
///
/// The declarations between the marks are plain C without a preprocessor, for other languages.
#ifndef JUDGE_API_H
#define JUDGE_API_H

#include <stdbool.h> // bool
#include <stddef.h>  // size_t
#include <stdint.h>  // uint32_t, int64_t

#if defined(__cplusplus)
extern "C" {
#endif
#if defined(__GNUC__)
#pragma GCC visibility push(default)
#endif

// [declarations]

/// A table on a machine.
typedef struct judge_api judge_api_t;

/// A limit and what a cut needs of it, in the unit of cam_refusal_t.
typedef struct {
    const char *name; ///< of the error that reports an excess: "u_speed" for cam_err_u_speed
    int64_t limit;
    int64_t needed;
} judge_api_demand_t;

/// What is known of a table before it is made: a part with lobes by the peaks of its motion.
typedef struct {
    uint32_t span_nm;   ///< height over which Z feeds
    uint32_t feed_nm;   ///< per turn
    uint32_t change_nm; ///< shortest height between two lobes; 0: none
    uint32_t u_nm;      ///< largest |u|
    uint32_t u1_peak_nm_per_rad, u2_peak_nm_per_rad2; ///< as in the header of a table
    uint32_t spindle_peak_ppm_per_rad;
    uint32_t ratio_max_q20;
    uint32_t swing_mdeg, swing1_mdeg_per_rad, swing2_mdeg_per_rad2; ///< at uniform speed
} judge_api_peaks_t;

/// Judge peaks instead of an image. @return a handle, to be closed; NULL when there is no memory
judge_api_t *judge_api_open_peaks(const judge_api_peaks_t *peaks, uint32_t tick_hz);

/// Check an image as a controller does, on a machine with default parameters.
/// @param image  bytes of a table, copied
/// @return       a handle, to be closed; NULL when there is no memory
judge_api_t *judge_api_open(const void *image, size_t size, uint32_t tick_hz);

/// Free a handle. NULL does nothing.
void judge_api_close(judge_api_t *j);

/// @return why the controller refuses the image, "" when it accepts it; nothing below may be called
///         for a refused image
const char *judge_api_refusal(const judge_api_t *j);

/// Set a parameter of the controller, rounded and limited to its range.
/// @param name  as in cam_param.h
/// @return      false when there is no such parameter
bool judge_api_set(judge_api_t *j, const char *name, double value);

/// List every limit and what the cut needs of it, in the order in which excesses are reported.
/// @param mrpm  [r/min / 1000] mean speed, below 2^26
/// @param n     length of the list
/// @return      the list, valid until the next call
const judge_api_demand_t *judge_api_demands(judge_api_t *j, uint32_t mrpm, size_t *n);

/// @return [r/min / 1000] highest feasible mean speed, 0 when there is none
uint32_t judge_api_highest_mrpm(const judge_api_t *j);

/// @return [nm] largest feasible feed at a mean speed, 0 when there is none
uint32_t judge_api_largest_feed_nm(const judge_api_t *j, uint32_t mrpm);

// [end of declarations]

#if defined(__GNUC__)
#pragma GCC visibility pop
#endif
#if defined(__cplusplus)
}
#endif

#endif
