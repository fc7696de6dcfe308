// SPDX-License-Identifier: Apache-2.0
/// cam_header_limits: does a table with a speed channel keep what its header promises of the
/// motion?
///
/// With r and r' of the speed channel, |u' r| and |u'' r^2 + u' r r'| must not exceed the promised
/// peaks at any knot of u, nor |r r'| its peak at any knot of speed. The rounding of this check
/// accepts an excess below 1/2048. Context: slow side; one evaluation of the speed for each knot.
#ifndef CAM_HEADER_LIMITS_H
#define CAM_HEADER_LIMITS_H

#include "cam_err.h"     // cam_err_t
#include "cam_channel.h" // cam_table_t

/// @param t  has u, speed, u1_peak_nm_per_rad, u2_peak_nm_per_rad2 and spindle_peak_ppm_per_rad
/// filled in;
///           each channel has been checked by itself
/// @return   cam_ok or cam_err_image_limits
CAM_MUST_USE cam_err_t cam_header_limits_check(const cam_table_t *t);

#endif
