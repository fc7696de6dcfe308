// SPDX-License-Identifier: Apache-2.0
/// cam_peaks: bounds of a channel's motion that the format does not store.
///
/// The bounds of a channel over angle hold between the knots too (cam_bounds.h). They exceed the
/// largest values by at most two per cent where the knots are as dense as a tolerance of 1e-4
/// degrees makes them. Context: slow side; one pass over the knots.
#ifndef CAM_PEAKS_H
#define CAM_PEAKS_H

#include "cam_channel.h" // cam_channel_t, cam_swing_peaks_t
#include <stdint.h>      // uint32_t

/// Bound the swing of the tool.
/// @param ch  kind swing, its knots checked
/// @return    bounds over all angles and heights, rounded up, saturated
cam_swing_peaks_t cam_peaks_of_swing(const cam_channel_t *ch);

/// Bound the third derivative of u: its jerk over the cube of the spindle speed.
/// @param ch  over angle and height, its knots checked
/// @return    [nm/rad3] bound over all angles and slices, rounded up, saturated
uint32_t cam_peaks_third(const cam_channel_t *ch);

/// Bound the change of a channel over height. Between two slices it is linear; at a slice its rate
/// jumps.
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

#endif
