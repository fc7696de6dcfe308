// SPDX-License-Identifier: Apache-2.0
/// cam_resolution_limit: the form error due to the resolution of the port's outputs, on a perfectly
/// tuned machine.
///
/// Context: slow side, integers only.
#ifndef CAM_RESOLUTION_LIMIT_H
#define CAM_RESOLUTION_LIMIT_H

#include "cam_table.h" // cam_table_t
#include <stdint.h>    // uint32_t

/// Bound the form error that the steps of the set-points cause: half a step of U, half a step of X,
/// and half a step of Z times the steepest slope of the part over its height.
/// @param table  in use; NULL: none, and the slope counts as 0
/// @return       [pm] rounded down, saturated; 0 when the port states no step at all
/// Source: MATHS.md (183).
uint32_t cam_resolution_limit_form_pm(const cam_table_t *table);

/// @param counts_per_turn  of the spindle's encoder, positive
/// @return [pm] largest motion of U per count of the encoder at uniform speed, rounded down,
///         saturated. Half of it bounds the form error of the counts where edges have no time
///         stamp.
/// Source: MATHS.md (185).
uint32_t cam_resolution_limit_count_pm(const cam_table_t *table, int32_t counts_per_turn);

#endif
