// SPDX-License-Identifier: Apache-2.0
/// cam_extent: what range of values a channel takes, between its knots and its slices too.
///
/// A quintic lies between its Bernstein coefficients. They are taken on the eighths of an interval,
/// as the tools do when they write the header, and in whole multiples of 1/327 680 LSB, so both
/// find the same numbers exactly. Between two slices the knots are blended linearly, so the values
/// lie between those of the slices. Source: TABLE_FORMAT.md, "The range of values"; MATHS.md (51);
/// Farouki, "The Bernstein polynomial basis: a centennial retrospective", CAGD 29 (2012). Context:
/// slow side.
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
/// @return the range of these values, an LSB for the rounding of the evaluation included, rounded
///         outwards
cam_extent_t cam_extent_of_knots(const cam_channel_t *ch, int32_t p_min, int32_t p_max);

/// Widen a range until it holds whatever the evaluation of a channel (cam_eval.h) returns at any
/// angle and height, its rounding of an LSB included.
/// @param ch         its knots keep the bounds of the format
/// @param is_around  it is over angle: the knot behind the last of a slice is the first
/// @param known      [unit] begin with what is promised, or with the range of the knots
/// @return           `known` where it holds everything already, else the least range of whole units
///                   around both
/// Cost: six sums for a knot, and where its quintic comes near an end of the range up to 14
/// halvings of the interval: TABLE_FORMAT.md has figures.
cam_extent_t cam_extent_widened(const cam_channel_t *ch, bool is_around, cam_extent_t known);

#endif
