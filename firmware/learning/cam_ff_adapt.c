// SPDX-License-Identifier: Apache-2.0
#include "cam_ff_adapt.h"
#include "cam_angle.h" // CAM_TWO_PI_Q24
#include "cam_fix.h"   // cam_clamp_i64, cam_abs_i64
#include <stdbool.h>   // bool

/// 2^40 / (2 pi): the speed in turns per tick becomes ticks per radian.
#define PER_RAD_Q40 INT64_C(174992711680)

/// Range of error and set-point in the sums: products with the fourth power of 16 fit 62 bits.
enum { most_bits = 21 };

cam_gain_t cam_drive_gain(uint32_t k, int32_t speed_q32, int32_t k1_q16, int32_t k2_q16)
{
    const int64_t most = INT64_C(1) << 20;
    const int64_t w_q24 = (int64_t)k * speed_q32 * (CAM_TWO_PI_Q24 >> 8) >> 24;
    const int64_t im_q12 = w_q24 * k1_q16 >> 28;
    const int64_t re_q12 = cam_gain_one_q12 - ((w_q24 * w_q24 >> 24) * k2_q16 >> 28);
    const cam_complex_t one = {.re = cam_gain_one_q12};
    return cam_gain_ratio(one, (cam_complex_t){.re = (int32_t)cam_clamp_i64(re_q12, -most, most),
                                               .im = (int32_t)cam_clamp_i64(im_q12, -most, most)});
}

/// @return a / 2^8, limited to the range of the sums
static cam_complex_t limited(cam_complex_t a)
{
    const int32_t most = 1 << most_bits;
    return (cam_complex_t){.re = cam_clamp_i32(a.re >> 8, -most, most),
                           .im = cam_clamp_i32(a.im >> 8, -most, most)};
}

void cam_drive_add(cam_drive_sums_t *sums, uint32_t k, cam_complex_t error, cam_complex_t set,
                   cam_gain_t gain)
{
    const cam_complex_t e = limited(error);
    const cam_complex_t v = limited(cam_gain_of(set, gain));
    const int64_t k2 = (int64_t)k * k;
    const int64_t square = (int64_t)cam_complex_square(v);
    const int64_t along = (int64_t)e.re * v.re + (int64_t)e.im * v.im;
    sums->error0 += along;
    sums->weight0 += square;
    sums->error1 += (int64_t)k * ((int64_t)e.im * v.re - (int64_t)e.re * v.im);
    sums->error2 += k2 * along;
    sums->weight1 += k2 * square;
    sums->weight2 += k2 * k2 * square;
}

void cam_friction_add(cam_drive_sums_t *sums, cam_complex_t error_q6, cam_complex_t sense_q20,
                      cam_gain_t gain)
{
    const cam_complex_t v = cam_gain_of(sense_q20, gain);
    sums->error_f += (int64_t)error_q6.re * v.re + (int64_t)error_q6.im * v.im;
    sums->weight_f += (int64_t)cam_complex_square(v);
}

/// @return a / b, limited to 1/4; 0 when b is 0
static int64_t share_q24(int64_t a, int64_t b)
{
    const int64_t most = INT64_C(1) << 22;
    int64_t part = a;
    int64_t of = b;
    while (cam_abs_i64(part) >= INT64_C(1) << 38) {
        part >>= 1;
        of >>= 1;
    }
    return of > 0 ? cam_clamp_i64(part * (INT64_C(1) << 24) / of, -most, most) : 0;
}

cam_drive_change_t cam_drive_solve(const cam_drive_sums_t *sums, int32_t speed_q32)
{
    const int64_t per_rad_q8 = PER_RAD_Q40 / speed_q32;
    const int64_t share1_q24 = share_q24(sums->error1, sums->weight1);
    const int64_t share2_q24 = share_q24(sums->error2, sums->weight2);
    // Smaller harmonics, below an eighth of a full reversal, do not determine the friction.
    const bool is_enough = sums->weight_f >> 34 > 0;
    return (cam_drive_change_t){
        .friction_q6 = is_enough ? cam_sat_i32(sums->error_f / (sums->weight_f >> 20)) : 0,
        .chip_q32 = (int32_t)(share_q24(sums->error0, sums->weight0) * 256),
        .k1_q16 = cam_sat_i32(share1_q24 * per_rad_q8 >> 16),
        .k2_q16 = cam_sat_i32(-((share2_q24 * per_rad_q8 >> 12) * per_rad_q8 >> 12)),
    };
}
