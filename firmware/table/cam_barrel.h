// SPDX-License-Identifier: Apache-2.0
/// cam_barrel: how steep and how bent X's profile is over height. Context: slow side.
#ifndef CAM_BARREL_H
#define CAM_BARREL_H

#include "cam_channel.h" // cam_table_t

/// Fill in x_slope_ppm and x_bend_ppm_per_m, UINT32_MAX where they are larger still.
/// @param t  its channel x passed the checks of a channel over height alone. The maxima are over
///           quarters of the slices: a peak between two of them is missed by at most the square of
///           an eighth of a slice times half the derivative after the next
/// Four evaluations for each slice.
void cam_barrel_measure(cam_table_t *t);

#endif
