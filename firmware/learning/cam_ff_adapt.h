// SPDX-License-Identifier: Apache-2.0
/// cam_ff_adapt: what a turn's error says of the drive's constants (layer 1) and of the correction
/// at each harmonic (layer 2).
///
/// E_k is the error of a harmonic, U_k its set-point, G_k the answer of U to a correction, in
/// layer 1 as the constants tell it, in layer 2 as probed:
///     layer 1   E_k / (U_k G_k) = j w_k dk1 - w_k^2 dk2, weighted least squares over all k
///     layer 2   c_k <- c_k + mu E_k / G_k
/// The guard of layer 2 keeps the smallest error of each harmonic and its correction; an error
/// 1.5 times as large brings that back and halves the gain, and the fourth time the harmonic stays
/// as it is. Source: MATHS.md (141) .. (144). Context of all functions: slow side.
#ifndef CAM_FF_ADAPT_H
#define CAM_FF_ADAPT_H

#include "cam_complex.h" // cam_complex_t, cam_gain_t
#include <stdint.h>      // int32_t, int64_t, uint32_t

/// Sums of layer 1 over the harmonics of a turn.
typedef struct {
    int64_t error1, weight1, error2, weight2;
} cam_drive_sums_t;

/// Changes of the drive's constants.
typedef struct {
    int32_t k1_q16; ///< [ticks]
    int32_t k2_q16; ///< [ticks^2]
} cam_drive_change_t;

/// @return the answer of the drive as the constants tell it, 1 / (1 + j w k1 - w^2 k2)
/// @param speed_q32       [turn / 2^32 per tick], above 0
/// @param k1_q16, k2_q16  [ticks], [ticks^2]
cam_gain_t cam_drive_gain(uint32_t k, int32_t speed_q32, int32_t k1_q16, int32_t k2_q16);

/// Add a harmonic to the sums of a turn.
/// @param error, set  [nm / 64] error and set-point of harmonic k, 1 .. 16, within +-2^31
void cam_drive_add(cam_drive_sums_t *sums, uint32_t k, cam_complex_t error, cam_complex_t set,
                   cam_gain_t gain);

/// @return what would remove the error of the turn, where all was linear
cam_drive_change_t cam_drive_solve(const cam_drive_sums_t *sums, int32_t speed_q32);

/// @return mu E / G in the unit of E, saturated; 0 when G is 0
cam_complex_t cam_harmonic_correction_change(cam_complex_t error, cam_gain_t gain, int32_t mu_q16);

#endif
