// SPDX-License-Identifier: Apache-2.0
/// cam_spindle_demand: what a speed channel demands of the speed loop of the spindle.
///
/// A loop of first order with the time constant T follows the ratio r of a mean speed m where its
/// set-point, m (r + c r r') with c = m T, lies between 0 and the highest speed. It is not below 0
/// where -r' c <= 1. Context: slow side; one pass over the knots. Source: MATHS.md (80).
#ifndef CAM_SPINDLE_DEMAND_H
#define CAM_SPINDLE_DEMAND_H

#include "cam_channel.h" // cam_channel_t, cam_spindle_demand_t
#include <stdint.h>      // uint32_t, uint64_t

/// @param ch  kind speed, its knots checked, or absent: then everything is that of the ratio 1
/// @return    largest values at the knots, rounded up
cam_spindle_demand_t cam_spindle_demand_of(const cam_channel_t *ch);

/// @param c_q16  [rad / 2^16] mean speed times time constant of the loop, below 2^40
/// @return       [2^-20] bound of r + c r r': the set-point over the mean speed; it never falls
/// with
///               rising c. Between the places where it was measured it is taken from the chord,
///               which is above it, since the largest of straight lines is convex, and beyond the
///               last one from the largest r r'.
uint64_t cam_spindle_demand_set_q20(const cam_spindle_demand_t *pace, uint64_t c_q16);

#endif
