// SPDX-License-Identifier: Apache-2.0
#include "cam_x_slope.h"
#include "cam_eval.h" // cam_eval_profile
#include "cam_fix.h"  // cam_abs_i64

enum { per_slice = 4 }; ///< samples

/// @param per_slice_lsb  [LSB per slice]
/// @return               [1e-6] its magnitude as a slope
static uint64_t slope_ppm(const cam_channel_t *x, int64_t per_slice_lsb)
{
    const uint64_t rise = (uint64_t)cam_abs_i64(per_slice_lsb) * 1000000u * (x->n_slices - 1u);
    return (rise >> x->frac_bits) / x->span_nm;
}

/// @param per_slice_ppm  [1e-6 per slice]
/// @return               [1e-6 / m] UINT32_MAX where the product would overflow
static uint64_t bend_ppm_per_m(const cam_channel_t *x, uint64_t per_slice_ppm)
{
    const uint64_t most_ppm = UINT64_C(1) << 21; // 2^21 10^9 2^12 < 2^63
    return per_slice_ppm < most_ppm ? per_slice_ppm * 1000000000u * (x->n_slices - 1u) / x->span_nm
                                    : UINT32_MAX;
}

/// @return the larger of the two, saturated
static uint32_t larger_u32(uint32_t most, uint64_t value)
{
    const uint32_t held = value < UINT32_MAX ? (uint32_t)value : UINT32_MAX;
    return held > most ? held : most;
}

cam_x_slope_t cam_x_slope_of(const cam_channel_t *x)
{
    const uint32_t n = (x->n_slices - 1u) * (uint32_t)per_slice;
    cam_x_slope_t most = {0};
    for (uint32_t i = 0; i <= n; i++) {
        const int32_t up_nm = (int32_t)((uint64_t)x->span_nm * i / n);
        const cam_value_t at = cam_eval_profile(x, x->z_first_nm + up_nm);
        const uint64_t bend = bend_ppm_per_m(x, slope_ppm(x, at.d2));
        most.slope_ppm = larger_u32(most.slope_ppm, slope_ppm(x, at.d1));
        most.rise_ppm = larger_u32(most.rise_ppm, at.d1 > 0 ? slope_ppm(x, at.d1) : 0u);
        most.bend_ppm_per_m = larger_u32(most.bend_ppm_per_m, bend);
    }
    return most;
}
