// SPDX-License-Identifier: Apache-2.0
/// cam_bounds: how large a quintic of the table and its derivatives become, between knots too.
///
/// Value and first derivative lie between their Bernstein coefficients, the second derivative is
/// taken at 32nds of every interval with a bound of what lies between. Source: MATHS.md (51).
/// Context: slow side.
#ifndef CAM_BOUNDS_H
#define CAM_BOUNDS_H

#include "cam_channel.h" // cam_channel_t
#include <stdint.h>      // int64_t, uint32_t

/// A knot of TABLE_FORMAT.md, or a sum or difference of some; magnitudes below 2^40.
typedef struct {
    int64_t p, v, a;
} cam_wide_knot_t;

/// Largest magnitudes so far, in the LSB of the knots and per knot interval; 0 to begin with.
typedef struct {
    int64_t tenfold;     ///< value, times 10
    int64_t twice;       ///< first derivative, times 2
    int64_t second_8192; ///< second derivative, times 8192
} cam_bounds_t;

/// Widen value and first derivative by the quintic between two knots. Each bound is at most eight
/// thirds too large, and within a few per cent where the knots follow a smooth function.
void cam_bounds_add(cam_bounds_t *b, const cam_wide_knot_t *k0, const cam_wide_knot_t *k1);

/// Widen the second derivative, within 1 % also beside a knot where the third one jumps.
void cam_bounds_add_second(cam_bounds_t *b, const cam_wide_knot_t *k0, const cam_wide_knot_t *k1);

/// @param i  of a knot of a channel over angle, counted over all slices
/// @return   the next one of the same slice, cyclic
uint32_t cam_bounds_next(const cam_channel_t *ch, uint32_t i);

#endif
