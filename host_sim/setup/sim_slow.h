// SPDX-License-Identifier: Apache-2.0
/// sim_slow: whether a slow spindle counts as stopped for the controller.
///
/// Below stopped_mrpm a spindle counts as stopped: with such a mean speed homing never ends, and a
/// cut ends in the fault spindle_stopped when the speed stays below it for longer than stopped_ms.
/// A modulated spindle may be that slow in a part of each turn. The check uses the speed demanded
/// by the table. Just below the limit, lag and ripple of the spindle may still end the cut, and the
/// noise of a coarse encoder may hide a slow spindle from the controller.
#ifndef SIM_SLOW_H
#define SIM_SLOW_H

#include "cam_refusal.h"  // cam_refusal_t
#include "cam_param.h"    // cam_params_t
#include "cam_table.h"    // cam_table_t
#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool

/// @return [s] longest time within a turn below stopped_mrpm, over all heights and 1440 angles; two
///         turns if it is always below
double sim_slow_longest_s(const cam_table_t *table, const cam_params_t *params, double mean_rpm);

/// @return false when a spindle of that mean speed counts as stopped
bool sim_slow_is_turning(const cam_table_t *table, const cam_params_t *params, double mean_rpm);

/// @param feasibility  for the mean speed, within all limits
/// @return             false and *e, with the remedy, when that speed is too slow
bool sim_slow_check(const cam_table_t *table, const cam_params_t *params,
                    const cam_refusal_t *feasibility, common_error_t *e);

#endif
