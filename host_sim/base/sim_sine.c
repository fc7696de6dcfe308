// SPDX-License-Identifier: Apache-2.0
#include "sim_units.h"

/// @param quarter  [turn] -1/4 .. 1/4
static double series(double quarter)
{
    static const double c[11] = {
        1.0,
        -1.0 / 6.0,
        1.0 / 120.0,
        -1.0 / 5040.0,
        1.0 / 362880.0,
        -1.0 / 39916800.0,
        1.0 / 6227020800.0,
        -1.0 / 1307674368000.0,
        1.0 / 355687428096000.0,
        -1.0 / 121645100408832000.0,
        1.0 / 51090942171709440000.0,
    };
    const double y = SIM_TWO_PI * quarter;
    const double z = y * y;
    const double w = z * z;
    // Two short sums, which a processor adds side by side, instead of a long one.
    const double even = c[0] + w * (c[2] + w * (c[4] + w * (c[6] + w * (c[8] + w * c[10]))));
    const double odd = c[1] + w * (c[3] + w * (c[5] + w * (c[7] + w * c[9])));
    return y * (even + z * odd);
}

double sim_sine(double turn)
{
    const double part = turn - sim_round(turn); // -1/2 .. 1/2
    return series(part > 0.25 ? 0.5 - part : part < -0.25 ? -0.5 - part : part);
}

double sim_cosine(double turn)
{
    return series(0.25 - sim_abs(turn - sim_round(turn)));
}
