// SPDX-License-Identifier: Apache-2.0
/// sim_slow: whether the controller would take a slow spindle for one that stands.
///
/// Below stopped_mrpm a spindle counts as stopped: with such a mean speed homing never ends, and a
/// cut ends in the fault spindle_stopped when the speed stays below it for longer than stopped_ms.
/// A modulated spindle may be so slow in a part of each turn. The speed that the table demands is
/// judged. Just below the limit, lag and ripple of the spindle may still end the cut, and the noise
/// of a coarse encoder may hide a slow spindle from the controller.
#ifndef SIM_SLOW_H
#define SIM_SLOW_H

#include "cam_feasible.h" // cam_feasibility_t
#include "cam_param.h"    // cam_params_t
#include "cam_table.h"    // cam_table_t
#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool

/// @return [s] longest time within a turn in which the spindle is slower than stopped_mrpm, over
///         all heights and 1440 angles; twice the turn where it always is
double sim_slow_longest_s(const cam_table_t *table, const cam_params_t *params, double mean_rpm);

/// @return false when the controller would take a spindle of that mean speed for stopped
bool sim_slow_is_turning(const cam_table_t *table, const cam_params_t *params, double mean_rpm);

/// @param feasibility  of the mean speed, which is within all limits
/// @return             false and *e, with the remedy, when that speed is so slow
bool sim_slow_check(const cam_table_t *table, const cam_params_t *params,
                    const cam_feasibility_t *feasibility, common_error_t *e);

#endif
