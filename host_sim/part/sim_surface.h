// SPDX-License-Identifier: Apache-2.0
/// sim_surface: a skirt of any shape as polynomial pieces over angle and height.
///
///     delta = sum over k = 0 .. 5, l = 0 .. 7 of c[j][i][k][l] t^k w^l,   t, w = 0 .. 1
///
/// on piece i of the angle coordinate s and piece j of the height, MATHS.md (19). For a measured
/// part s is the turn, 0 .. 1. For a two-fold section with a joint s is 0 on the long axis, 1 at
/// the joint, 2 on the short axis, whatever the angle of the joint at this height. Measured
/// sections are given by "knots", a value and two derivatives per turn at every height and break,
/// and by "slopes", the same for the slope over height; without slopes they are interpolated
/// linearly over height. The pieces in the generator's report define refitted and measured skirts.
/// Error: rounding only, below 1e-6 nm.
#ifndef SIM_SURFACE_H
#define SIM_SURFACE_H

#include "sim_cubics.h"   // sim_cubics_t
#include "common_error.h" // common_error_t
#include <cjson/cJSON.h>
#include <stdbool.h> // bool
#include <stddef.h>  // size_t

enum { sim_surface_n_angle = 6, sim_surface_n_height = 8 };

typedef struct {
    bool has_joint;
    sim_cubics_t joint_turn; ///< [turn] over height, with a joint only
    double *breaks;          ///< n + 1, rising, 0 .. 1 or 0 .. 2
    double *break_mm;        ///< m + 1, rising
    double (*c)[sim_surface_n_angle][sim_surface_n_height]; ///< [mm] m * n pieces
    size_t n, m;
    size_t i_last, j_last; ///< pieces of the last look-up, start of the next search
} sim_surface_t;

/// Read the surface of a report's design or target.
/// @param s            zero-initialised; the caller frees it, also on failure
/// @param where, path  dotted path of the surface, and the file, for messages
/// @return             false and *e when something is missing or malformed
bool sim_surface_read(sim_surface_t *s, const cJSON *surface, const char *where, const char *path,
                      common_error_t *e);

/// Evaluate the surface.
/// @param turn  [turn] drawing's angle, any
/// @param z_mm  any; clamped to the pieces
/// @return      [mm] reduction of the radius
double sim_surface_delta_mm(sim_surface_t *s, double turn, double z_mm);

void sim_surface_free(sim_surface_t *s);

#endif
