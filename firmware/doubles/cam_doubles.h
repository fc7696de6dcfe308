// SPDX-License-Identifier: Apache-2.0
/// cam_doubles: doubles on the slow side, and their conversion to integers.
///
/// IEEE 754 defines + - * /, root, comparisons and conversions to the last bit, so every host and
/// core calculates the same numbers. Nothing else is used: no other function of a mathematical
/// library, no float, no long double; firmware/CMakeLists.txt forbids the compiler to contract a
/// product and a sum. Rooms that the interrupt runs contain no doubles (tools/cmake/
/// firmware_lint.cmake, tools/elfcheck). Divisors differ from 0, so no number should be infinite or
/// NaN; limits and conversions saturate if one is.
/// Context of all functions: slow side.
#ifndef CAM_DOUBLES_H
#define CAM_DOUBLES_H

#include <stdint.h> // int32_t

_Static_assert(__FLT_EVAL_METHOD__ == 0,
               "doubles without excess precision: on 32-bit x86 -mfpmath=sse");
_Static_assert(__DBL_MANT_DIG__ == 53, "IEEE doubles");

#define CAM_PI 3.14159265358979324

/// @return v limited to -most .. most; -most for NaN
static inline double cam_limit(double v, double most)
{
    return v > most ? most : v >= -most ? v : -most;
}

/// @return v rounded to nearest, half away from 0, saturated; INT32_MIN for NaN
int32_t cam_nearest(double v);

/// @return square root of v, at least 0
double cam_root(double v);

#endif
