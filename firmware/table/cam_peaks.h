// SPDX-License-Identifier: Apache-2.0
/// cam_peaks: how far, how fast and with what acceleration a table swings the tool, and how much it
/// changes from one slice to the next.
///
/// Bounds of the quintics themselves, not only of their knots (cam_bounds.h). They are within two
/// per cent of the largest values where the knots are as dense as a tolerance of 1e-4 degrees makes
/// them. Context: slow side; one pass over the knots.
#ifndef CAM_PEAKS_H
#define CAM_PEAKS_H

#include "cam_channel.h" // cam_channel_t, cam_swing_peaks_t

/// @param ch  kind swing, passed the checks of its knots
/// @return    bounds over all angles and heights, rounded up, saturated
cam_swing_peaks_t cam_peaks_of_swing(const cam_channel_t *ch);

/// Between two slices a channel changes by their difference, evenly with height: its rate jumps
/// where one slice ends and the next begins, by what one difference is more than the other.
/// @param ch  over angle, passed the checks of its knots
/// @return    bounds over all angles and slices, rounded up, saturated; 0 of equal slices
cam_change_t cam_peaks_of_change(const cam_channel_t *ch);

#endif
