// SPDX-License-Identifier: Apache-2.0
/// cam_fix: fixed-point operations, inline, for both sides.
///
/// `_q<n>` in a name tells the number of fraction bits. Right shifts of negative numbers are
/// arithmetic in every compiler that we support (asserted below), so they round towards minus
/// infinity. Left shifts are written as multiplications: a negative left operand is undefined in
/// C11.
#ifndef CAM_FIX_H
#define CAM_FIX_H

#include <stdint.h> // int32_t, int64_t

_Static_assert((-3 >> 1) == -2, "arithmetic right shift");

/// High word of the product: one instruction on Cortex-M4/M7.
/// @return floor(a * b / 2^32), any arguments
static inline int32_t cam_mulhi(int32_t a, int32_t b)
{
    return (int32_t)(((int64_t)a * b) >> 32);
}

/// @return a * b / 2^n rounded to nearest, half up; 1 <= n <= 62; the product must fit int32
static inline int32_t cam_mul_shift(int32_t a, int32_t b, uint32_t n)
{
    return (int32_t)(((int64_t)a * b + ((int64_t)1 << (n - 1u))) >> n);
}

/// @return v limited to [lo, hi]
static inline int32_t cam_clamp_i32(int32_t v, int32_t lo, int32_t hi)
{
    return v < lo ? lo : v > hi ? hi : v;
}

/// @return v limited to [lo, hi]
static inline int64_t cam_clamp_i64(int64_t v, int64_t lo, int64_t hi)
{
    return v < lo ? lo : v > hi ? hi : v;
}

/// @return v limited to the range of int32
static inline int32_t cam_sat_i32(int64_t v)
{
    const int32_t low = (int32_t)v; // fits when its sign extension is v again
    return low == v ? low : v < 0 ? INT32_MIN : INT32_MAX;
}

/// @return |v|; any v but INT64_MIN
static inline int64_t cam_abs_i64(int64_t v)
{
    return v < 0 ? -v : v;
}

/// a - b on the wrapping scale of a free-running counter.
/// @return [LSB] signed distance, correct while the true distance is within +-2^31
static inline int32_t cam_wrap_diff(uint32_t a, uint32_t b)
{
    return (int32_t)(a - b);
}

#endif
