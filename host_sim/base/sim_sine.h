// SPDX-License-Identifier: Apache-2.0
/// sim_sine: sine and cosine of an angle in turns, for what every tick evaluates.
///
/// The nearest whole number of turns is subtracted, which is exact; then the angle is mirrored into
/// a quarter turn to either side. There y = 2 pi turn, and the series ends with y^21:
///
///     sin y = y - y^3 / 3! + y^5 / 5! - .. + y^21 / 21!
///
/// The next term is below (pi / 2)^23 / 23! = 1.3e-18; the rest is rounding. The error is below
/// 5e-16 at any angle and does not grow over a run. Only sums and products are used, so the bits do
/// not depend on the processor, as those of the C library's sine do.
#ifndef SIM_SINE_H
#define SIM_SINE_H

/// @param turn  [turn] |turn| < 2^51
/// @return      sin(2 pi turn)
double sim_sine(double turn);

/// @param turn  [turn] |turn| < 2^51
/// @return      cos(2 pi turn)
double sim_cosine(double turn);

#endif
