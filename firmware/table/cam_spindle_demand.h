// SPDX-License-Identifier: Apache-2.0
/// cam_spindle_demand: demand of a speed channel on the spindle's speed loop, and the check of the
/// motion limits in the header of a table with one.
///
/// A first-order loop with time constant T follows the ratio r of a mean speed m if its set-point
/// m (r + c r r'), c = m T, stays between 0 and the highest speed. It is not negative where
/// -r' c <= 1. Context: slow side; one pass over the knots. Source: MATHS.md (80).
#ifndef CAM_SPINDLE_DEMAND_H
#define CAM_SPINDLE_DEMAND_H

#include "cam_channel.h" // cam_channel_t, cam_spindle_demand_t
#include "cam_err.h"     // cam_err_t
#include <stdint.h>      // uint32_t, uint64_t

/// @param ch  kind speed, its knots checked; absent: the ratio is 1
/// @return    largest values at the knots, rounded up
cam_spindle_demand_t cam_spindle_demand_of(const cam_channel_t *ch);

/// @param c_q16  [rad / 2^16] mean speed times time constant of the loop, below 2^40
/// @return       [2^-20] bound of r + c r r', the set-point over the mean speed; never falls with
///               rising c. The maximum of straight lines is convex, so the chord between two
///               measured c bounds it; beyond the last one the largest r r' does.
uint64_t cam_spindle_demand_set_q20(const cam_spindle_demand_t *demand, uint64_t c_q16);

/// Check that with r and r' of the speed channel, |u' r| and |u'' r^2 + u' r r'| do not exceed
/// their limits at any knot of u, nor |r r'| its limit at any knot of speed. Rounding accepts an
/// excess below 1/2048. One evaluation of the speed for each knot.
/// @param t  checked channels u and speed, and the three peaks of the header
/// @return   cam_ok or cam_err_image_limits
CAM_MUST_USE cam_err_t cam_header_limits_check(const cam_table_t *t);

#endif
