// SPDX-License-Identifier: Apache-2.0
/// cam_envelope: smooth step by which depth and amplitude rise and fall, MATHS.md (55).
///
/// The quintic step over some turns starts and ends without a jump in speed. A drive with a lag
/// would arrive late; it is commanded the inverse of its own motion, MATHS.md (58).
/// Context: ISR, constant time.
#ifndef CAM_ENVELOPE_H
#define CAM_ENVELOPE_H

#include <stdint.h> // int32_t, int64_t, uint32_t

/// Quintic smooth step 10 s^3 - 15 s^4 + 6 s^5.
/// @param s_q31  [1 / 2^31] 0 .. 2^31 - 1
/// @return       [1 / 2^30] 0 .. 2^30, error below 2^-24
int32_t cam_envelope_smooth_q30(int32_t s_q31);

/// Command that makes a drive follow the smooth step over a length. A lag of up to a sixteenth of
/// the length is inverted, which overshoots the end by at most 12 / 16^3 of the step; the rest of a
/// longer lag is compensated by reading ahead.
/// @param done_q32        [turn] since the start of the step; any value
/// @param lag_q32         [turn] travelled during the lag of the drive
/// @param length_q32      [turn] of the step, up to 100 turns
/// @param per_length_q31  [1/turn] its reciprocal
/// @return                [1 / 2^30] 0 before the step, 2^30 after it
int32_t cam_envelope_step_q30(int64_t done_q32, int64_t lag_q32, int64_t length_q32,
                              uint32_t per_length_q31);

#endif
