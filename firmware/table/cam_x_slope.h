// SPDX-License-Identifier: Apache-2.0
/// cam_x_slope: slope and curvature of X's profile over height (the barrel form of a piston).
#ifndef CAM_X_SLOPE_H
#define CAM_X_SLOPE_H

#include "cam_channel.h" // cam_channel_t

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
/// Context: slow side; four evaluations per slice.
cam_x_slope_t cam_x_slope_of(const cam_channel_t *x);

#endif
