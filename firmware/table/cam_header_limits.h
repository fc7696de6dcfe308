// SPDX-License-Identifier: Apache-2.0
/// cam_header_limits: check of the header's motion limits for a table with a speed channel.
///
/// With r and r' of the speed channel, |u' r| and |u'' r^2 + u' r r'| must not exceed their limits
/// at any knot of u, nor |r r'| its limit at any knot of speed. The check's own rounding accepts an
/// excess below 1/2048. Context: slow side; one evaluation of the speed for each knot.
#ifndef CAM_HEADER_LIMITS_H
#define CAM_HEADER_LIMITS_H

#include "cam_err.h"     // cam_err_t
#include "cam_channel.h" // cam_table_t

/// @param t  checked channels u and speed, and the three peaks of the header
/// @return   cam_ok or cam_err_image_limits
CAM_MUST_USE cam_err_t cam_header_limits_check(const cam_table_t *t);

#endif
