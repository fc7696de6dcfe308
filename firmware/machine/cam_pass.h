// SPDX-License-Identifier: Apache-2.0
/// cam_pass: sequence and settings of the passes of a table.
///
/// A pass has a feed, a speed and an allowance, which offsets X. The parameters feed_nm and
/// spindle_mrpm, where set, override those of all passes; x_trim_nm is added to the allowance. A
/// table without passes counts as one pass with the values of its header. Source: MATHS.md (105).
/// Context: slow side.
#ifndef CAM_PASS_H
#define CAM_PASS_H

#include "cam_err.h"     // cam_err_t
#include "cam_refusal.h" // cam_refusal_t
#include "cam_param.h"   // cam_params_t
#include "cam_table.h"   // cam_table_t
#include <stdint.h>      // uint32_t

/// @return number of passes, at least 1, even without a table (NULL)
uint32_t cam_pass_count(const cam_table_t *table);

/// @param i  pass, below cam_pass_count()
/// @return   parameters of the pass; the swing's speed is 0 on a machine without swing axis
cam_params_t cam_pass_params(const cam_params_t *params, const cam_table_t *table, uint32_t i);

/// @return the first pass of a part: the one set by the parameter `pass`, else 0
uint32_t cam_pass_first(const cam_params_t *params, const cam_table_t *table);

/// @return the pass after pass i: after the last the first; always cam_pass_first() where the
///         parameter `pass` is set
uint32_t cam_pass_next(const cam_params_t *params, const cam_table_t *table, uint32_t i);

/// Find the first infeasible pass.
/// @param speed_mrpm  [r/min / 1000] 0: each pass at its own speed
/// @param i           result: that pass, or the last one where all are feasible
CAM_MUST_USE cam_err_t cam_pass_check(const cam_table_t *table, const cam_params_t *params,
                                      uint32_t speed_mrpm, uint32_t tick_hz, uint32_t *i);

/// Check one pass, with the details of cam_feasible(). Parameters as for cam_pass_check().
cam_refusal_t cam_pass_feasibility(const cam_table_t *table, const cam_params_t *params,
                                   uint32_t speed_mrpm, uint32_t tick_hz, uint32_t i);

/// @return [r/min / 1000] highest speed feasible for all passes; 0: none
uint32_t cam_pass_highest_mrpm(const cam_table_t *table, const cam_params_t *params,
                               uint32_t tick_hz);

#endif
