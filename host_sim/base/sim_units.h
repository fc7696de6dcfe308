// SPDX-License-Identifier: Apache-2.0
/// sim_units: constants, rounding and the sine of a turn for all models.
#ifndef SIM_UNITS_H
#define SIM_UNITS_H

#include <math.h>   // fabs
#include <stdint.h> // int64_t

#define SIM_PI 3.14159265358979323846
#define SIM_TWO_PI 6.28318530717958647692
#define SIM_NM_PER_MM 1e6
#define SIM_UDEG_PER_TURN 360e6
#define SIM_Q32_PER_UDEG (4294967296.0 / SIM_UDEG_PER_TURN)
#define SIM_UDEG_PER_Q32 (SIM_UDEG_PER_TURN / 4294967296.0)

/// Round to the nearest integer, ties to even, without a library call.
/// @param v  |v| < 2^51
static inline double sim_round(double v)
{
    const double lift = 6755399441055744.0; // 1.5 * 2^52: doubles this large are whole numbers
    return (v + lift) - lift;
}

/// @return the largest integer not above v; |v| < 2^62
static inline int64_t sim_floor(double v)
{
    const int64_t cut = (int64_t)v;
    return cut - ((double)cut > v ? 1 : 0);
}

/// @return v - floor(v), 0 <= result < 1 up to the rounding of a tiny negative v to 1
static inline double sim_fraction(double v)
{
    return v - (double)sim_floor(v);
}

static inline double sim_clamp(double v, double lo, double hi)
{
    const double above = v < lo ? lo : v; // two instructions, without a jump
    return above > hi ? hi : above;
}

static inline double sim_abs(double v)
{
    return fabs(v); // one instruction
}

// Sine and cosine of an angle in turns, for what every tick evaluates.
//
// The nearest whole number of turns is subtracted, which is exact; then the angle is mirrored into
// a quarter turn to either side. There y = 2 pi turn, and the series ends with y^21:
//
//     sin y = y - y^3 / 3! + y^5 / 5! - .. + y^21 / 21!
//
// The next term is below (pi / 2)^23 / 23! = 1.3e-18; the rest is rounding. The error is below
// 5e-16 at any angle and does not grow over a run. Only sums and products are used, so the bits do
// not depend on the processor, as those of the C library's sine do.

/// @param turn  [turn] |turn| < 2^51
/// @return      sin(2 pi turn)
double sim_sine(double turn);

/// @param turn  [turn] |turn| < 2^51
/// @return      cos(2 pi turn)
double sim_cosine(double turn);

#endif
