// SPDX-License-Identifier: Apache-2.0
/// cam_complex: complex numbers in fixed point, inline.
///
/// Source: MATHS.md (140). Context of all functions: slow side.
#ifndef CAM_COMPLEX_H
#define CAM_COMPLEX_H

#include "cam_doubles.h" // cam_nearest, cam_root
#include "cam_fix.h"     // cam_sat_i32
#include <stdint.h>      // int32_t, int64_t, uint32_t, uint64_t

typedef struct {
    int32_t re, im;
} cam_complex_t;

/// A transfer function of U; 2^12 is 1, so up to 8.
typedef struct {
    int16_t re_q12;
    int16_t im_q12;
} cam_gain_t;

enum { cam_gain_one_q12 = 1 << 12 };

/// @return a + b; the parts of the sum must fit int32
static inline cam_complex_t cam_complex_add(cam_complex_t a, cam_complex_t b)
{
    return (cam_complex_t){.re = a.re + b.re, .im = a.im + b.im};
}

/// @return a - b; the parts of the difference must fit int32
static inline cam_complex_t cam_complex_sub(cam_complex_t a, cam_complex_t b)
{
    return (cam_complex_t){.re = a.re - b.re, .im = a.im - b.im};
}

/// @return |a|^2
static inline uint64_t cam_complex_square(cam_complex_t a)
{
    return (uint64_t)((int64_t)a.re * a.re) + (uint64_t)((int64_t)a.im * a.im);
}

/// @return |a|, rounded down, at most 3 037 000 499
static inline uint32_t cam_complex_size(cam_complex_t a)
{
    return (uint32_t)cam_root((double)cam_complex_square(a));
}

/// @return |g|^2 of a transfer function, 2^24 is 1
static inline uint32_t cam_gain_square_q24(cam_gain_t g)
{
    return (uint32_t)((int32_t)g.re_q12 * g.re_q12) + (uint32_t)((int32_t)g.im_q12 * g.im_q12);
}

/// @return a g, saturated
static inline cam_complex_t cam_gain_of(cam_complex_t a, cam_gain_t g)
{
    return (cam_complex_t){
        .re = cam_sat_i32(((int64_t)a.re * g.re_q12 - (int64_t)a.im * g.im_q12) >> 12),
        .im = cam_sat_i32(((int64_t)a.re * g.im_q12 + (int64_t)a.im * g.re_q12) >> 12),
    };
}

/// @return (re + j im) / by as a transfer function, limited to +-7.99; 0 when by is 0
static inline cam_gain_t cam_gain_divided(double re, double im, double by)
{
    const double unit = by > 0.0 ? cam_gain_one_q12 / by : 0.0;
    return (cam_gain_t){.re_q12 = (int16_t)cam_nearest(cam_limit(re * unit, INT16_MAX)),
                        .im_q12 = (int16_t)cam_nearest(cam_limit(im * unit, INT16_MAX))};
}

/// @return a / b, likewise
static inline cam_gain_t cam_gain_ratio(cam_complex_t a, cam_complex_t b)
{
    return cam_gain_divided((double)a.re * b.re + (double)a.im * b.im,
                            (double)a.im * b.re - (double)a.re * b.im,
                            (double)cam_complex_square(b));
}

#endif
