// SPDX-License-Identifier: Apache-2.0
/// cam_harmonic_correction: correction of U's command over the spindle's angle, one harmonic at a
/// time.
///
/// Two probes of different size give U's response G to a correction. A harmonic at which U responds
/// weakly or not in proportion is masked, until a larger probe agrees with the one before. Then c
/// <- c + mu E / G. For each harmonic but the mean, the smallest error is kept with its correction;
/// an error 1.5 times as large, and above the noise floor, restores that correction and halves mu,
/// and the fourth time masks the harmonic. The correction is for full amplitude. Source: MATHS.md
/// (142) .. (144). Context: slow side.
#ifndef CAM_HARMONIC_CORRECTION_H
#define CAM_HARMONIC_CORRECTION_H

#include "cam_complex.h"   // cam_complex_t, cam_gain_t
#include "cam_harmonics.h" // cam_harmonics_most
#include <stdbool.h>       // bool
#include <stdint.h>        // int16_t, int32_t, uint32_t

enum { cam_harmonic_terms = cam_harmonics_most + 1 };

/// State, made by cam_harmonic_correction_forget().
typedef struct {
    cam_complex_t c_q6[cam_harmonic_terms]; ///< [nm / 64] the correction
    struct {
        int16_t re_nm;
        int16_t im_nm;
    } kept[cam_harmonic_terms];           ///< correction of the smallest error; while probing: the
                                          ///< error without a probe
    uint32_t best_q6[cam_harmonic_terms]; ///< [nm / 64] the smallest error, UINT32_MAX: none
    uint32_t last_q6[cam_harmonic_terms]; ///< [nm / 64] last error, UINT32_MAX: of a new cause
    cam_gain_t gain[cam_harmonic_terms];  ///< response G of U
    uint8_t n_halved[cam_harmonic_terms]; ///< times that mu was halved
    uint32_t masked;                      ///< bit k
    bool is_probed;
} cam_harmonic_correction_t;

/// Clear the correction, the responses and the smallest errors.
void cam_harmonic_correction_forget(cam_harmonic_correction_t *s);

/// Forget the smallest errors, because the cutting conditions have changed.
void cam_harmonic_correction_restart_guard(cam_harmonic_correction_t *s);

/// Replace the correction by a probe, p e^(j pi k^2 / n) at harmonic k: its crest factor is low.
/// @param size_q6  [nm / 64] p; 0 ends the probe
/// @param n        harmonics, 1 .. 16
/// @param which    bit k: harmonic k is probed
void cam_harmonic_correction_set_probe(cam_harmonic_correction_t *s, int32_t size_q6, uint32_t n,
                                       uint32_t which);

/// Evaluate the error of a revolution while probing.
/// @param stage  0: no probe, 1: first probe, 2: second probe, which masks; later ones unmask
/// @param error_q6  [nm / 64] of harmonic k at full amplitude
void cam_harmonic_correction_probe(cam_harmonic_correction_t *s, uint32_t stage, uint32_t k,
                                   cam_complex_t error_q6);

/// Update the correction at harmonic k from the error of a revolution.
/// @param error_q6  [nm / 64] at full amplitude
/// @param floor_q6  [nm / 64] noise floor of the scale
/// @param mu_q16    learning gain, 0 .. 2^16
/// @param room_q6   [nm / 64] by which the sum of sizes may still grow; a change that does not
///                  fit is scaled down. What it uses is subtracted
/// @return whether the error has not grown since the last turn
bool cam_harmonic_correction_learn(cam_harmonic_correction_t *s, uint32_t k, cam_complex_t error_q6,
                                   uint32_t floor_q6, int32_t mu_q16, uint32_t *room_q6);

/// Raise the smallest error by a sixteenth: in the cut the conditions drift. Not for an error that
/// grows, because learning may diverge.
void cam_harmonic_correction_age(cam_harmonic_correction_t *s, uint32_t k);

/// Scale the correction. @param part_q16  0 .. 2^16
void cam_harmonic_correction_scale(cam_harmonic_correction_t *s, uint32_t part_q16);

/// Restore the correction of the smallest error at every harmonic.
void cam_harmonic_correction_restore(cam_harmonic_correction_t *s);

/// @return [nm / 64] sum of the magnitudes
uint32_t cam_harmonic_correction_sum_q6(const cam_harmonic_correction_t *s);

/// Rotate the correction with the pattern.
void cam_harmonic_correction_rotate(cam_harmonic_correction_t *s, uint32_t angle_q32);

#endif
