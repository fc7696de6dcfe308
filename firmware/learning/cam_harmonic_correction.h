// SPDX-License-Identifier: Apache-2.0
/// cam_harmonic_correction: the correction of U's command over the angle, a harmonic at a time.
///
/// A probe plays two corrections of different size and sees what each does to the error: that is
/// the answer G of U. A harmonic to which U hardly answers, or not in proportion, is masked. Then
/// c <- c + mu E / G, under a guard that keeps the best. The correction is over the angle of the
/// spindle, at full amplitude. Source: MATHS.md (142) .. (144). Context: slow side.
#ifndef CAM_HARMONIC_CORRECTION_H
#define CAM_HARMONIC_CORRECTION_H

#include "cam_complex.h"   // cam_complex_t, cam_gain_t
#include "cam_harmonics.h" // cam_harmonics_most
#include <stdbool.h>       // bool
#include <stdint.h>        // int16_t, int32_t, uint32_t

enum { cam_harmonic_terms = cam_harmonics_most + 1 };

/// State; zero-initialised knows nothing and corrects nothing.
typedef struct {
    cam_complex_t c_q6[cam_harmonic_terms]; ///< [nm / 64] the correction
    struct {
        int16_t re_nm;
        int16_t im_nm;
    } kept[cam_harmonic_terms];           ///< that of the smallest error; in the probe: the
                                          ///< error before it
    uint32_t best_q6[cam_harmonic_terms]; ///< [nm / 64] the smallest error, UINT32_MAX: none
    cam_gain_t gain[cam_harmonic_terms];  ///< answer of U
    uint8_t n_halved[cam_harmonic_terms]; ///< times that the guard halved the gain
    uint32_t masked;                      ///< bit k
    bool is_probed;
} cam_harmonic_correction_t;

/// Forget everything.
void cam_harmonic_correction_forget(cam_harmonic_correction_t *s);

/// Let the guard begin anew, because the work has changed.
void cam_harmonic_correction_renew(cam_harmonic_correction_t *s);

/// Put a probe in the place of the correction: p e^(j pi k^2 / n) at harmonic k, whose sum over the
/// turn is never much larger than its mean square.
/// @param size_q6  [nm / 64] p; 0 ends the probe
/// @param n        harmonics, 1 .. 16
void cam_harmonic_correction_play(cam_harmonic_correction_t *s, int32_t size_q6, uint32_t n);

/// Take the error of a turn of the probe.
/// @param stage  0: nothing played, 1: the first probe, 2: the second one
/// @param error_q6  [nm / 64] of harmonic k at full amplitude
void cam_harmonic_correction_probe(cam_harmonic_correction_t *s, uint32_t stage, uint32_t k,
                                   cam_complex_t error_q6);

/// Take the error of a turn of learning, and change the correction at harmonic k.
/// @param error_q6  [nm / 64] at full amplitude
/// @param floor_q6  [nm / 64] what the scale cannot tell from nothing
/// @param mu_q16    0 .. 2^16
/// @param room_q6   [nm / 64] by how much the magnitudes of all corrections may grow
void cam_harmonic_correction_learn(cam_harmonic_correction_t *s, uint32_t k, cam_complex_t error_q6,
                                   uint32_t floor_q6, int32_t mu_q16, uint32_t room_q6);

/// Let the best error age, by a sixteenth: in the cut the work changes.
void cam_harmonic_correction_age(cam_harmonic_correction_t *s, uint32_t k);

/// Go back to the best, harmonic for harmonic.
void cam_harmonic_correction_restore(cam_harmonic_correction_t *s);

/// @return [nm / 64] sum of the magnitudes
uint32_t cam_harmonic_correction_sum_q6(const cam_harmonic_correction_t *s);

/// Turn the correction, because the operator turned the shape.
void cam_harmonic_correction_turn(cam_harmonic_correction_t *s, uint32_t angle_q32);

#endif
