// SPDX-License-Identifier: Apache-2.0
/// cam_peaks: bounds of a channel's motion that the format does not store, and the check of those
/// that the header of a table with a speed channel guarantees.
///
/// The bounds of a channel over angle hold between the knots too (cam_bounds.h). They exceed the
/// largest values by at most two per cent where the knots are as dense as a tolerance of 1e-4
/// degrees makes them. Context: slow side; one pass over the knots.
#ifndef CAM_PEAKS_H
#define CAM_PEAKS_H

#include "cam_channel.h" // cam_channel_t, cam_swing_peaks_t, cam_spindle_demand_t
#include "cam_err.h"     // cam_err_t
#include <stdint.h>      // uint32_t, uint64_t

/// Bound the swing of the tool.
/// @param ch  kind swing, its knots checked
/// @return    bounds over all angles and heights, rounded up, saturated
cam_swing_peaks_t cam_peaks_of_swing(const cam_channel_t *ch);

/// Bound the third derivative of u: its jerk over the cube of the spindle speed.
/// @param ch  over angle and height, its knots checked
/// @return    [nm/rad3] bound over all angles and slices, rounded up, saturated
uint32_t cam_peaks_third(const cam_channel_t *ch);

/// Rms of the second derivative over a turn, from its values at the knots.
/// @param ch  over angle and height, its knots checked
/// @return    [nm/rad2] largest of all slices, rounded up, saturated
uint32_t cam_peaks_rms_second(const cam_channel_t *ch);

/// Bound the change of a channel over height: linear between slices, with a kink at each slice.
/// @param ch  over angle and height, its knots checked
/// @return    bounds over all angles and slices, rounded up, saturated; 0 when the slices are equal
cam_change_t cam_peaks_of_change(const cam_channel_t *ch);

/// Largest slope and curvature of a channel over height, saturated at UINT32_MAX.
typedef struct {
    uint32_t slope_ppm;      ///< [1e-6] magnitude of the slope
    uint32_t rise_ppm;       ///< [1e-6] largest slope; 0 where none is above 0
    uint32_t bend_ppm_per_m; ///< [1e-6 / m] magnitude of the second derivative
} cam_x_slope_t;

/// Measure the slope and curvature that X and Z must be able to follow (cam_demand.h).
/// @param x  a channel over height alone whose knots have been checked
/// @return   from samples at quarters of the slice spacing; a peak of a function f between samples
///           is missed by at most (spacing / 8)^2 / 2 times the largest |f''|
cam_x_slope_t cam_x_slope_of(const cam_channel_t *x);

/// Bound the demand of a speed channel on the spindle's speed loop. A first-order loop with time
/// constant T follows the ratio r of a mean speed m if its set-point m (r + c r r'), c = m T, stays
/// between 0 and the highest speed. It is not negative where -r' c <= 1. Source: MATHS.md (80).
/// @param ch  kind speed, its knots checked; absent: the ratio is 1
/// @return    largest values at the knots, rounded up
cam_spindle_demand_t cam_peaks_of_speed(const cam_channel_t *ch);

/// @param c_q16  [rad / 2^16] mean speed times time constant of the loop, below 2^40
/// @return       [2^-20] bound of r + c r r', the set-point over the mean speed; never falls with
///               rising c. The maximum of straight lines is convex, so the chord between two
///               measured c bounds it; beyond the last one the largest r r' does.
uint64_t cam_peaks_set_point_q20(const cam_spindle_demand_t *demand, uint64_t c_q16);

/// Check that with r and r' of the speed channel, |u' r| and |u'' r^2 + u' r r'| do not exceed
/// their limits at any knot of u, nor |r r'| its limit at any knot of speed. Rounding accepts an
/// excess below 1/2048. One evaluation of the speed for each knot.
/// @param t  checked channels u and speed, and the three peaks of the header
/// @return   cam_ok or cam_err_image_limits
CAM_MUST_USE cam_err_t cam_peaks_check(const cam_table_t *t);

#endif
