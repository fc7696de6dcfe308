// SPDX-License-Identifier: Apache-2.0
/// cam_bounds: bounds of a table's quintics and of their derivatives, between the knots too.
///
/// Value, first and third derivative are bounded by their Bernstein coefficients. The second
/// derivative is evaluated at 32nds of every interval, and the largest deviation between them is
/// added. The range of a channel's values is found from the coefficients on the eighths of every
/// interval, in whole multiples of 1/327 680 LSB, so that the tools, which write the header, find
/// exactly the same numbers. Between two slices the knots are blended linearly, so the values there
/// are between those of the slices. Source: TABLE_FORMAT.md, "The range of values"; MATHS.md (51);
/// Farouki, "The Bernstein polynomial basis: a centennial retrospective", CAGD 29 (2012). Context:
/// slow side.
#ifndef CAM_BOUNDS_H
#define CAM_BOUNDS_H

#include "cam_channel.h" // cam_channel_t
#include <stdbool.h>     // bool
#include <stdint.h>      // int64_t, uint32_t

/// A knot, or a sum or difference of several; magnitudes below 2^40.
typedef struct {
    int64_t p, v, a;
} cam_wide_knot_t;

/// Largest magnitudes so far, in the LSB of the knots and per knot interval; starts with zeros.
/// Scaled so that no segment needs a division.
typedef struct {
    int64_t tenfold;     ///< value, times 10
    int64_t twice;       ///< first derivative, times 2
    int64_t second_8192; ///< second derivative, times 8192
    int64_t third;       ///< third derivative
} cam_bounds_t;

/// Widen the bounds of value and first derivative by the quintic between two knots. A bound is at
/// most 8/3 of the true maximum, a few per cent above it where the knots follow a smooth function.
void cam_bounds_add(cam_bounds_t *b, const cam_wide_knot_t *k0, const cam_wide_knot_t *k1);

/// Widen the bound of the second derivative by the quintic between two knots: within 1 % of the
/// true maximum, even next to a knot at which the third derivative jumps.
void cam_bounds_add_second(cam_bounds_t *b, const cam_wide_knot_t *k0, const cam_wide_knot_t *k1);

/// Widen the bound of the third derivative, which jumps at the knots.
void cam_bounds_add_third(cam_bounds_t *b, const cam_wide_knot_t *k0, const cam_wide_knot_t *k1);

/// @param i  index of a knot of a channel over angle, counted over all slices
/// @return   index of the next knot of the same slice; the first follows the last
uint32_t cam_bounds_next(const cam_channel_t *ch, uint32_t i);

/// A range of values in the unit of a channel.
typedef struct {
    int64_t low, high;
} cam_extent_t;

/// @param p_min, p_max  [LSB] bounds of the values of the knots
/// @return              their range plus an LSB for the evaluation's rounding, rounded outwards
cam_extent_t cam_extent_of_knots(const cam_channel_t *ch, int64_t p_min, int64_t p_max);

/// Widen a range to all values that cam_eval.h returns for a channel, with an LSB for its rounding.
/// @param ch         its knots keep the bounds of the format
/// @param is_around  it is over angle: the knot after the last of a slice is the first
/// @param known      [unit] initial range: the guaranteed one, or that of the knots
/// @return           the smallest range of whole units that holds `known` and all values
/// Cost: six sums per knot, and near an end of the range 7 halvings; TABLE_FORMAT.md has figures.
cam_extent_t cam_extent_widened(const cam_channel_t *ch, bool is_around, cam_extent_t known);

#endif
