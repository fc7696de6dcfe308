// SPDX-License-Identifier: Apache-2.0
/// cam_harmonics: harmonics of the bins of a revolution, and points of a revolution from harmonics.
///
///     c_k  = (2 / 128) sum m_i e^(-jk theta_i)   theta_i the middle of bin i; c_0 is the mean
///     f(i) = Re sum c_k e^(jk 2 pi i / 256)      i = 0 .. 256, c_0 real
///
/// Both use the same 256 angles, so angles are exact. Source: MATHS.md (140).
/// Context of all functions: slow side.
#ifndef CAM_HARMONICS_H
#define CAM_HARMONICS_H

#include "cam_complex.h"   // cam_complex_t
#include "cam_turn_bins.h" // cam_turn_bins_n
#include <stdbool.h>       // bool
#include <stdint.h>        // int16_t, int32_t, uint32_t

enum { cam_harmonics_most = 16 }; ///< the highest harmonic that is learned

/// @return cos(2 pi step / 256), 2^24 is 1
int32_t cam_cos_q24(uint32_t step);

/// @return sin(2 pi step / 256), 2^24 is 1
int32_t cam_sin_q24(uint32_t step);

/// One harmonic of 128 bins.
/// @param mean    of the first bin, within +-2^31
/// @param stride  [words] from a bin to the next
/// @param k       0 .. 63
/// @return        in the unit of the means, rounded, saturated
cam_complex_t cam_harmonics_of(const int32_t *mean, uint32_t stride, uint32_t k);

/// @return c e^(jk angle), relative error up to 8e-5
cam_complex_t cam_harmonics_rotated(cam_complex_t c, uint32_t k, uint32_t angle_q32);

/// Move the points of a revolution towards a sum of harmonics, each by at most one step.
/// @param point  258 of them, changed in place, the last two equal to the first two
/// @param c      harmonics 0 .. 16, parts within +-2^23, the sum of their magnitudes below 2^24
/// @param down   1 .. 24; a point is the sum / 2^down, within +-32767
/// @param most   largest change of a point, above 0
/// @return       whether all points have reached their targets
bool cam_harmonics_slew(int16_t *point, const cam_complex_t *c, uint32_t down, int32_t most);

#endif
