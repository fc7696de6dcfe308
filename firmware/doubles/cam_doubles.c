// SPDX-License-Identifier: Apache-2.0
#include "cam_doubles.h"

int64_t cam_nearest_i64(double v)
{
    if (v >= 0x1p63) {
        return INT64_MAX;
    }
    if (v < -0x1p63) {
        return INT64_MIN;
    }
    const int64_t whole = (int64_t)v; // towards 0
    const double part = v - (double)whole;
    return part >= 0.5 ? whole + 1 : part <= -0.5 ? whole - 1 : whole;
}

int32_t cam_nearest(double v)
{
    const int64_t whole = cam_nearest_i64(v);
    return whole > INT32_MAX ? INT32_MAX : whole < INT32_MIN ? INT32_MIN : (int32_t)whole;
}

double cam_root(double v)
{
    return __builtin_sqrt(v);
}
