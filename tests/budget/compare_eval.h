// SPDX-License-Identifier: Apache-2.0
/// compare_eval: ways to evaluate a surface over angle and height, ours and plain C of others.
///
/// Each one takes a machine angle and a height, clamps the height, and blends the knots of two
/// slices linearly before it interpolates over the angle; what differs is the arithmetic and the
/// order. The others find their interval by one 32 x 32 bit multiplication, so that any number of
/// knots serves. compare_table.h makes the tables.
#ifndef COMPARE_EVAL_H
#define COMPARE_EVAL_H

#include "cam_eval.h" // cam_value_t
#include <stdint.h>   // uint32_t

/// Knot of a cubic spline.
typedef struct {
    float y; ///< [nm]
    float m; ///< second derivative * h^2 / 6, h = one knot interval
} compare_spline_knot_t;

/// Knot of a quintic: those of cam_knot_t in nm.
typedef struct {
    double p, v, a;
} compare_quintic_knot_t;

/// A surface as one of the ways stores it.
typedef struct {
    const cam_channel_t *ours;
    const double *linear;                  ///< [nm] [n_slices][n_knots]
    const compare_spline_knot_t *spline;   ///< [n_slices][n_knots]
    const compare_quintic_knot_t *quintic; ///< [n_slices][n_knots]
    uint32_t n_knots;                      ///< of one pattern
    uint32_t n_slices;                     ///< from height 0 on
    uint32_t log2_repeat;                  ///< patterns per turn
    uint32_t span_nm;                      ///< [nm] height of the last slice
    double slices_per_nm;
    float slices_per_nm_float;
} compare_table_t;

/// Value and derivatives per knot interval, in the way's own type.
typedef union {
    cam_value_t ours; ///< [LSB]
    float single[3];  ///< [nm]
    double twice[3];  ///< [nm]; linear: value only
} compare_value_t;

/// @param theta_q32  [turn / 2^32] any value
/// @param z_nm       [nm] any value
typedef void compare_fn(const compare_table_t *t, uint32_t theta_q32, int32_t z_nm,
                        compare_value_t *value);

compare_fn compare_ours;    ///< cam_eval_surface_at(): value, two derivatives
compare_fn compare_linear;  ///< double: value
compare_fn compare_spline;  ///< float: value, two derivatives
compare_fn compare_quintic; ///< double: value, two derivatives
compare_fn compare_nothing; ///< what a call costs

#endif
