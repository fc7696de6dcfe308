// SPDX-License-Identifier: Apache-2.0
#include "cam_real.h"
#include "cam_fix.h" // cam_root_u64
#include <stdbool.h> // bool

cam_real_t cam_real_scaled(uint64_t v, int32_t e)
{
    if (v == 0u) {
        return (cam_real_t){0};
    }
    uint32_t up = 0;
    while ((v << up) >> 63 == 0u) {
        up++;
    }
    return (cam_real_t){.m = (uint32_t)((v << up) >> 32), .e = e + 32 - (int32_t)up};
}

cam_real_t cam_real_times(cam_real_t a, cam_real_t b)
{
    return cam_real_scaled((uint64_t)a.m * b.m, a.e + b.e);
}

cam_real_t cam_real_over(cam_real_t a, cam_real_t b)
{
    return cam_real_scaled(((uint64_t)a.m << 32) / b.m, a.e - b.e - 32);
}

/// @return m 2^30 of b, for the exponent of a, which is at least as large
static uint64_t aligned(cam_real_t a, cam_real_t b)
{
    const int32_t down = a.e - b.e;
    return b.m == 0u || down > 62 ? 0u : ((uint64_t)b.m << 30) >> down;
}

cam_real_t cam_real_plus(cam_real_t a, cam_real_t b)
{
    const bool is_less = a.m == 0u || (b.m != 0u && a.e < b.e);
    const cam_real_t more = is_less ? b : a;
    const cam_real_t less = is_less ? a : b;
    return cam_real_scaled(((uint64_t)more.m << 30) + aligned(more, less), more.e - 30);
}

cam_real_t cam_real_minus(cam_real_t a, cam_real_t b)
{
    return cam_real_scaled(((uint64_t)a.m << 30) - aligned(a, b), a.e - 30);
}

cam_real_t cam_real_root(cam_real_t a)
{
    const int32_t odd = a.e & 1;
    return cam_real_scaled(cam_root_u64((uint64_t)a.m << (30 + odd)), (a.e - 30 - odd) / 2);
}

int64_t cam_real_to_q(cam_real_t a, int32_t q)
{
    const int32_t up = a.e + q;
    if (a.m == 0u || up < -33) {
        return 0;
    }
    if (up > 30) {
        return INT64_C(1) << 62;
    }
    if (up >= 0) {
        return (int64_t)a.m << up;
    }
    return (int64_t)((((uint64_t)a.m << 1) >> -up) + 1u) >> 1;
}
