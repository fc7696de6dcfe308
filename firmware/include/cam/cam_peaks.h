// SPDX-License-Identifier: Apache-2.0
/// cam_peaks: how far, how fast and with what acceleration a table swings the tool.
///
/// Bounds of the quintics themselves, not only of their knots: value and speed lie between their
/// Bernstein coefficients, the acceleration is taken at eighths of every interval with a bound of
/// what lies between. They are within two per cent of the largest values where the knots are as
/// dense as a tolerance of 1e-4 degrees makes them. Context: slow side; one pass over the knots.
#ifndef CAM_PEAKS_H
#define CAM_PEAKS_H

#include "cam/cam_table.h" // cam_channel_t, cam_swing_peaks_t

/// @param ch  kind swing, passed the checks of its knots
/// @return    bounds over all angles and heights, rounded up, saturated
/// Source: Farouki, "The Bernstein polynomial basis: a centennial retrospective", CAGD 29 (2012).
cam_swing_peaks_t cam_peaks_of_swing(const cam_channel_t *ch);

#endif
