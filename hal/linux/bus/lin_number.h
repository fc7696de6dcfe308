// SPDX-License-Identifier: Apache-2.0
/// lin_number: clamping and rounding division of integers.
#ifndef LIN_NUMBER_H
#define LIN_NUMBER_H

#include <stdint.h> // int32_t, int64_t

static inline int32_t lin_clamp_i32(int64_t value)
{
    return value < INT32_MIN ? INT32_MIN : value > INT32_MAX ? INT32_MAX : (int32_t)value;
}

/// @param b  not 0
/// @return   a / b, rounded to nearest, halves away from 0
static inline int64_t lin_div_round(int64_t a, int64_t b)
{
    const int64_t half = (b < 0 ? -b : b) / 2;
    return (a < 0 ? a - half : a + half) / b;
}

/// @param b  above 0
/// @return   a / b, rounded down
static inline int64_t lin_div_floor(int64_t a, int64_t b)
{
    return a / b - (a % b < 0 ? 1 : 0);
}

#endif
