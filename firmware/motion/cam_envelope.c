// SPDX-License-Identifier: Apache-2.0
#include "cam_motion.h"
#include "cam_fix.h" // cam_mulhi

/// [1] in the unit of envelopes.
#define ONE_Q30 (INT32_C(1) << 30)

/*@ requires share: s_q31 >= 0;
    assigns \result \from s_q31;
    ensures step: 0 <= \result <= 0x40000000;
*/
int32_t cam_envelope_smooth_q30(int32_t s_q31)
{
    const int32_t s2_q31 = 2 * cam_mulhi(s_q31, s_q31);
    const int32_t s3_q31 = 2 * cam_mulhi(s2_q31, s_q31);
    const uint32_t inner_q28 =
        (UINT32_C(10) << 28) - 15u * ((uint32_t)s_q31 >> 3) + 6u * ((uint32_t)s2_q31 >> 3);
    const uint32_t y_q30 = (uint32_t)(((uint64_t)(uint32_t)s3_q31 * inner_q28) >> 29);
    return y_q30 < UINT32_C(1) << 30 ? (int32_t)y_q30 : ONE_Q30; // rounding may pass 1
}

/// Addition to the smooth step s that makes a drive with a lag follow it. Two equal poles of half
/// the lag each are inverted by lag s' + (lag / 2)^2 s''; with d the lag as a share of the step:
///     d (30 q^2 + 15 d q (1 - 2 s)),   q = s (1 - s)
/// @param s_q31  [1 / 2^31] 0 .. 2^31 - 1
/// @param d_q31  [1 / 2^31] 0 .. 2^31 / 16
/// @return       [1 / 2^30]
/*@ requires share: s_q31 >= 0;
    requires lag: 0 <= d_q31 <= 0xFFFFFFF;
    assigns \result \from s_q31, d_q31;
    ensures most: -0x10000000 <= \result <= 0x10000000;
*/
static int32_t inverse_q30(int32_t s_q31, int32_t d_q31)
{
    const int32_t q_q31 = 2 * cam_mulhi(s_q31, INT32_MAX - s_q31);
    const int32_t slope_q31 = (int32_t)((uint32_t)INT32_MAX - 2u * (uint32_t)s_q31);
    const int32_t bend_q31 = 2 * cam_mulhi(d_q31, slope_q31);
    const int32_t sum_q30 = 30 * cam_mulhi(q_q31, q_q31) + 15 * cam_mulhi(q_q31, bend_q31);
    return 2 * cam_mulhi(sum_q30, d_q31);
}

int32_t cam_envelope_step_q30(int64_t done_q32, int64_t lag_q32, int64_t length_q32,
                              uint32_t per_length_q31)
{
    const int64_t led_q32 = cam_wrap_add_i64(done_q32, lag_q32);
    if (led_q32 <= 0 || done_q32 >= length_q32) { // most of a cut
        return led_q32 <= 0 ? 0 : ONE_Q30;
    }
    const int64_t inverted_q32 = cam_clamp_i64(lag_q32, 0, length_q32 / 16);
    const int64_t at_q32 = led_q32 - inverted_q32;
    if (at_q32 <= 0 || at_q32 >= length_q32) {
        return at_q32 <= 0 ? 0 : ONE_Q30;
    }
    const uint32_t at_q24 = (uint32_t)(at_q32 >> 8); // 100 turns at most
    const uint32_t lag_q24 = (uint32_t)(inverted_q32 >> 8);
    // The reciprocal is rounded down, so the shares are below 1 and 1/16; the masks prove it.
    const int32_t s_q31 = (int32_t)((((uint64_t)at_q24 * per_length_q31) >> 24) & 0x7FFFFFFFu);
    const int32_t d_q31 = (int32_t)((((uint64_t)lag_q24 * per_length_q31) >> 24) & 0x0FFFFFFFu);
    return cam_envelope_smooth_q30(s_q31) + inverse_q30(s_q31, d_q31);
}
