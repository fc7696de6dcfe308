// SPDX-License-Identifier: Apache-2.0
/// cam_pass: which pass of a table is cut, and with which numbers.
///
/// A pass brings its feed, its speed and the stock that it leaves, which X is offset by. Parameters
/// that are set (feed_nm, spindle_mrpm) overrule those of all passes, and x_trim_nm is added to
/// the stock. A table without passes has one, of the numbers in its header. Source: MATHS.md (105).
/// Context: slow side.
#ifndef CAM_PASS_H
#define CAM_PASS_H

#include "cam_err.h"      // cam_err_t
#include "cam_feasible.h" // cam_feasibility_t
#include "cam_param.h"    // cam_params_t
#include "cam_table.h"    // cam_table_t
#include <stdint.h>       // uint32_t

/// @return number of passes, at least 1; also without a table (NULL)
uint32_t cam_pass_count(const cam_table_t *table);

/// @param i  pass, below cam_pass_count()
/// @return   the parameters with which it is cut, as this machine can fulfil them: without an axis
///           for the swing its speed is 0, whatever was set
cam_params_t cam_pass_params(const cam_params_t *params, const cam_table_t *table, uint32_t i);

/// @return the pass with which a part begins: that of the parameter `pass`, or the first one
uint32_t cam_pass_first(const cam_params_t *params, const cam_table_t *table);

/// @return the pass that follows another one: the next one, after the last the first; the same
///         where the parameter `pass` names one
uint32_t cam_pass_next(const cam_params_t *params, const cam_table_t *table, uint32_t i);

/// Find the first pass that is infeasible.
/// @param speed_mrpm  [r/min / 1000] 0: that of each pass
/// @param i           result: the pass; the last one where all are feasible
CAM_MUST_USE cam_err_t cam_pass_check(const cam_table_t *table, const cam_params_t *params,
                                      uint32_t speed_mrpm, uint32_t tick_hz, uint32_t *i);

/// Judge a pass with all numbers (cam_feasible()). Parameters as of cam_pass_check().
cam_feasibility_t cam_pass_feasibility(const cam_table_t *table, const cam_params_t *params,
                                       uint32_t speed_mrpm, uint32_t tick_hz, uint32_t i);

/// @return [r/min / 1000] highest speed that is feasible for all passes; 0 when there is none
uint32_t cam_pass_highest_mrpm(const cam_table_t *table, const cam_params_t *params,
                               uint32_t tick_hz);

#endif
