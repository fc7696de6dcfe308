// SPDX-License-Identifier: Apache-2.0
/// cam_extent: the range of a channel's values, including those between knots and slices.
///
/// A quintic is bounded by its Bernstein coefficients. They are taken on the eighths of an interval
/// in whole multiples of 1/327 680 LSB, so that the tools, which write the header, find exactly the
/// same numbers. Between two slices the knots are blended linearly, so the values there are between
/// those of the slices. Source: TABLE_FORMAT.md, "The range of values"; MATHS.md (51); Farouki,
/// "The Bernstein polynomial basis: a centennial retrospective", CAGD 29 (2012). Context: slow
/// side.
#ifndef CAM_EXTENT_H
#define CAM_EXTENT_H

#include "cam_channel.h" // cam_channel_t
#include <stdbool.h>     // bool
#include <stdint.h>      // int32_t, int64_t

/// A range of values in the unit of a channel.
typedef struct {
    int64_t low, high;
} cam_extent_t;

/// @param p_min, p_max  [LSB] bounds of the values of the knots
/// @return              their range plus an LSB for the evaluation's rounding, rounded outwards
cam_extent_t cam_extent_of_knots(const cam_channel_t *ch, int64_t p_min, int64_t p_max);

/// Widen a range until it holds every value that cam_eval.h returns for a channel, with an LSB for
/// its rounding.
/// @param ch         its knots keep the bounds of the format
/// @param is_around  it is over angle: the knot after the last of a slice is the first
/// @param known      [unit] initial range: the guaranteed one, or that of the knots
/// @return           the smallest range of whole units that holds `known` and all values
/// Cost: six sums per knot, and near an end of the range up to 14 halvings of the interval;
/// TABLE_FORMAT.md has figures.
cam_extent_t cam_extent_widened(const cam_channel_t *ch, bool is_around, cam_extent_t known);

#endif
