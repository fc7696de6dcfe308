// SPDX-License-Identifier: Apache-2.0
/// cam_feasible: whether this machine can turn this table at this speed, and if not, why.
///
/// Speeds are mean speeds. Where the table modulates the spindle, its highest speed within a turn
/// is larger by the largest ratio, and the peaks that the table guarantees contain the modulation.
/// Context of all functions: slow side. Source: MATHS.md (61).
#ifndef CAM_FEASIBLE_H
#define CAM_FEASIBLE_H

#include "cam_demand.h"  // cam_demands_t
#include "cam_err.h"     // cam_err_t
#include "cam_param.h"   // cam_params_t
#include "cam_refusal.h" // cam_refusal_t
#include "cam_table.h"   // cam_table_t
#include <stdint.h>      // uint32_t

/// Judge a speed, the verdict alone: one comparison with each limit.
/// @param speed_mrpm  [r/min / 1000] > 0
/// @param tick_hz     [Hz] rate of the tick
/// @return            cam_ok, or the error of the first limit that is exceeded
CAM_MUST_USE cam_err_t cam_feasible_check(const cam_table_t *table, const cam_params_t *params,
                                          uint32_t speed_mrpm, uint32_t tick_hz);

/// List every limit with what the cut needs of it. Parameters as of cam_feasible_check().
/// @param axes  filled with the limits of the axes
/// @return      the turns of feed, the only demand that falls with a rising feed
cam_demand_t cam_feasible_demands(const cam_table_t *table, const cam_params_t *params,
                                  uint32_t speed_mrpm, uint32_t tick_hz, cam_demands_t *axes);

/// Search the highest feasible speed by halving: 26 judgements.
/// @return [r/min / 1000] highest mean speed at which all limits hold; 0 when none does
uint32_t cam_feasible_highest_mrpm(const cam_table_t *table, const cam_params_t *params,
                                   uint32_t tick_hz);

/// Search the largest feasible feed by halving: 24 judgements.
/// @return [nm] largest feed per turn with which all limits hold at this speed; 0 when none does
uint32_t cam_feasible_largest_feed_nm(const cam_table_t *table, const cam_params_t *params,
                                      uint32_t speed_mrpm, uint32_t tick_hz);

/// Judge a speed and search the limits, for a message. Parameters as of cam_feasible_check().
/// @return the first limit that is exceeded, if any, and what would be feasible; `needed` is
///         rounded up
cam_refusal_t cam_feasible(const cam_table_t *table, const cam_params_t *params,
                           uint32_t speed_mrpm, uint32_t tick_hz);

/// @return [r/min / 1000] highest speed within a turn of this mean speed, rounded up, saturated.
/// Example: a ratio of up to 1.25 makes 1250 r/min of a mean speed of 1000 r/min.
uint32_t cam_feasible_peak_mrpm(const cam_table_t *table, uint32_t mean_mrpm);

#endif
