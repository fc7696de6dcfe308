// SPDX-License-Identifier: Apache-2.0
#include "cam_learning_inner.h"
#include "cam_doubles.h" // cam_limit, cam_nearest
#include <stdbool.h>     // bool

/// [1] largest share of an error that a turn changes
#define MOST_SHARE 0.25

cam_complex_t cam_drive_gain(uint32_t k, int32_t speed_q32, int32_t k1_q16, int32_t k2_q16)
{
    const double w = cam_drive_omega(k, speed_q32);
    const double re = 1.0 - w * w * k2_q16 * 0x1p-16;
    const double im = w * k1_q16 * 0x1p-16;
    return cam_gain_divided(re, -im, re * re + im * im);
}

void cam_drive_add(cam_drive_sums_t *sums, uint32_t k, cam_complex_t error, cam_complex_t set,
                   cam_complex_t gain)
{
    const cam_complex_t v = cam_gain_of(set, gain);
    const double square = (double)cam_complex_square(v);
    const double along = (double)error.re * v.re + (double)error.im * v.im;
    const double across = (double)error.im * v.re - (double)error.re * v.im;
    const double k2 = (double)k * k;
    sums->error0 += along;
    sums->weight0 += square;
    sums->error1 += k * across;
    sums->weight1 += k2 * square;
    sums->error2 += k2 * along;
    sums->weight2 += k2 * k2 * square;
}

void cam_friction_add(cam_drive_sums_t *sums, cam_complex_t error_q6, cam_complex_t sense_q20,
                      cam_complex_t gain)
{
    const cam_complex_t v = cam_gain_of(sense_q20, gain);
    sums->error_f += (double)error_q6.re * v.re + (double)error_q6.im * v.im;
    sums->weight_f += (double)cam_complex_square(v);
}

/// @return a / b, limited; 0 when b is 0
static double estimate(double a, double b)
{
    return b > 0.0 ? cam_limit(a / b, MOST_SHARE) : 0.0;
}

cam_drive_t cam_drive_solve(const cam_drive_sums_t *sums, int32_t speed_q32)
{
    const double per_rad = 1.0 / cam_drive_omega(1, speed_q32); // [ticks]
    const double k1 = estimate(sums->error1, sums->weight1) * per_rad;
    const double k2 = -estimate(sums->error2, sums->weight2) * per_rad * per_rad;
    // Smaller harmonics, below an eighth of a full reversal, do not determine the friction.
    const bool is_enough = sums->weight_f >= 0x1p34;
    return (cam_drive_t){
        .friction_q6 = is_enough ? cam_nearest(sums->error_f / sums->weight_f * 0x1p20) : 0,
        .chip_q32 = cam_nearest(estimate(sums->error0, sums->weight0) * 0x1p32),
        .k1_q16 = cam_nearest(k1 * 0x1p16),
        .k2_q16 = cam_nearest(k2 * 0x1p16),
    };
}
