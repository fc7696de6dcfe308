// SPDX-License-Identifier: Apache-2.0
/// cam_envelope: the step by which a cut rises and falls, MATHS.md (55).
///
/// Depth and amplitude enter and leave the work by a quintic smooth step over some turns, so that
/// they start and end without a jump in speed. A drive with a lag that follows the plain step
/// arrives late; it is commanded the inverse of its own motion, MATHS.md (58).
/// Context: ISR, constant time.
#ifndef CAM_ENVELOPE_H
#define CAM_ENVELOPE_H

#include <stdint.h> // int32_t, int64_t, uint32_t

/// Quintic smooth step 10 s^3 - 15 s^4 + 6 s^5.
/// @param s_q31  [1 / 2^31] 0 .. 2^31 - 1
/// @return       [1 / 2^30] 0 .. 2^30, error below 2^-24
int32_t cam_envelope_smooth_q30(int32_t s_q31);

/// The smooth step over a length, as a drive must be commanded to follow it. Up to a sixteenth of
/// the length is inverted, then the command overshoots the end by at most 12 / 16^3 of the step;
/// the rest of a longer lag is compensated for by reading ahead.
/// @param done_q32        [turn] behind the start of the step; any value
/// @param lag_q32         [turn] travelled during the lag of the drive, 0 where it has none
/// @param length_q32      [turn] of the step, up to 100 turns
/// @param per_length_q31  [1/turn] its reciprocal
/// @return                [1 / 2^30] 0 before the step, 2^30 behind it
int32_t cam_envelope_step_q30(int64_t done_q32, int64_t lag_q32, int64_t length_q32,
                              uint32_t per_length_q31);

#endif
