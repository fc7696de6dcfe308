// SPDX-License-Identifier: Apache-2.0
#include "cam_doubles.h"

int32_t cam_nearest(double v)
{
    const double beyond = v < 0.0 ? v - 0.5 : v + 0.5; // to be cut towards 0
    if (beyond >= 0x1p31) {
        return INT32_MAX;
    }
    return beyond > -0x1p31 ? (int32_t)beyond : INT32_MIN; // NaN is not above it
}

double cam_root(double v)
{
    return __builtin_sqrt(v);
}
