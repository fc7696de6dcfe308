// SPDX-License-Identifier: Apache-2.0
/// cam_promise: does a table with a speed channel keep what its header promises of the motion?
///
/// At every knot of u, with r and r' of the speed channel there, |u' r| and |u'' r^2 + u' r r'|
/// must not exceed the promised peaks; at every knot of speed |r r'| must not. Rounding is towards
/// acceptance by less than 1/2048. Context: slow side; one evaluation for each knot.
#ifndef CAM_PROMISE_H
#define CAM_PROMISE_H

#include "cam_err.h"     // cam_err_t
#include "cam_channel.h" // cam_table_t

/// @param t  with u, speed, u1_peak_nm_per_rad, u2_peak_nm_per_rad2 and spindle_peak_ppm filled in,
///           channels checked each by itself
/// @return   cam_ok or cam_err_image_limits
CAM_MUST_USE cam_err_t cam_promise_check(const cam_table_t *t);

#endif
