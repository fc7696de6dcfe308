// SPDX-License-Identifier: Apache-2.0
/// cam_ff_adapt: update of the drive's constants (layer 1) from the error of a revolution.
///
/// With the error E_k and the set-point U_k of harmonic k, and U's response G_k to a correction
/// according to the constants:
///     E_k / (U_k G_k) = j w_k dk1 - w_k^2 dk2, weighted least squares over all k
/// Source: MATHS.md (141) .. (144). Context of all functions: slow side.
#ifndef CAM_FF_ADAPT_H
#define CAM_FF_ADAPT_H

#include "cam_complex.h" // cam_complex_t, cam_gain_t
#include "cam_doubles.h" // CAM_PI
#include <stdint.h>      // int32_t, uint32_t

/// Sums of layer 1 over the harmonics of a revolution.
typedef struct {
    double error1, weight1, error2, weight2;
    double error0, weight0;   ///< of the chip's force
    double error_f, weight_f; ///< of the friction
} cam_drive_sums_t;

/// Changes of the drive's constants.
typedef struct {
    int32_t k1_q16;      ///< [ticks]
    int32_t k2_q16;      ///< [ticks^2]
    int32_t friction_q6; ///< [nm / 64]
    int32_t chip_q32;    ///< [1] of the set-point
} cam_drive_change_t;

/// @return [rad per tick] angular frequency of harmonic k
static inline double cam_drive_omega(uint32_t k, int32_t speed_q32)
{
    return 2.0 * CAM_PI * k * speed_q32 * 0x1p-32;
}

/// @return U's response at harmonic k according to the constants, 1 / (1 + j w k1 - w^2 k2)
/// @param speed_q32       [turn / 2^32 per tick], above 0
/// @param k1_q16, k2_q16  [ticks], [ticks^2]
cam_gain_t cam_drive_gain(uint32_t k, int32_t speed_q32, int32_t k1_q16, int32_t k2_q16);

/// Add a harmonic to the sums of a revolution.
/// @param error, set  [nm / 64] error and set-point of harmonic k, 1 .. 16, within +-2^31
void cam_drive_add(cam_drive_sums_t *sums, uint32_t k, cam_complex_t error, cam_complex_t set,
                   cam_gain_t gain);

/// Add a harmonic in which U hardly moves to the sums of the friction.
/// @param error_q6   [nm / 64] not divided by the amplitude
/// @param sense_q20  harmonic of the sense in which U moves, 2^20 is 1
void cam_friction_add(cam_drive_sums_t *sums, cam_complex_t error_q6, cam_complex_t sense_q20,
                      cam_gain_t gain);

/// @return change of the constants that removes the error of the revolution in a linear drive
cam_drive_change_t cam_drive_solve(const cam_drive_sums_t *sums, int32_t speed_q32);

#endif
