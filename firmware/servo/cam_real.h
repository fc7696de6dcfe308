// SPDX-License-Identifier: Apache-2.0
/// cam_real: products, quotients, sums and roots of positive numbers of any size, in integers.
///
/// A number is m 2^e with 2^31 <= m < 2^32, or m = 0. Each function rounds its result down by at
/// most 2^-30 of it; after cam_real_minus() the error refers to the larger operand. Exponents stay
/// far within 32 bits for anything physical. Context: slow side.
#ifndef CAM_REAL_H
#define CAM_REAL_H

#include <stdint.h> // int32_t, int64_t, uint32_t, uint64_t

typedef struct {
    uint32_t m;
    int32_t e;
} cam_real_t;

#define CAM_REAL_PI ((cam_real_t){0xC90FDAA2u, -30})

/// @return v 2^e
cam_real_t cam_real_scaled(uint64_t v, int32_t e);

/// @return v
static inline cam_real_t cam_real(uint32_t v)
{
    return cam_real_scaled(v, 0);
}

cam_real_t cam_real_times(cam_real_t a, cam_real_t b);

/// @param b  above 0
cam_real_t cam_real_over(cam_real_t a, cam_real_t b);

cam_real_t cam_real_plus(cam_real_t a, cam_real_t b);

/// @param b  at most a
cam_real_t cam_real_minus(cam_real_t a, cam_real_t b);

cam_real_t cam_real_root(cam_real_t a);

/// @return a 2^q rounded to nearest, at most 2^62
int64_t cam_real_to_q(cam_real_t a, int32_t q);

#endif
