// SPDX-License-Identifier: Apache-2.0
/// sim_surface: a skirt of any shape as polynomial pieces over angle and height.
///
///     delta = sum over k = 0 .. 5, l = 0 .. 7 of c[j][i][k][l] t^k w^l,   t, w = 0 .. 1
///
/// on piece i of the angle coordinate s and piece j of the height, MATHS.md (19). Of a measured
/// part s is the turn, 0 .. 1. Of a two-fold section with a joint s counts from the long axis, 1 at
/// the joint, 2 at the short axis, whatever the angle of the joint at this height. Measured
/// sections are told by "knots", value and two derivatives by the turn at every height and break,
/// and by "slopes", the same of the slope over the height; without slopes heights are joined by
/// straight lines. The generator writes the pieces into its report; refitted and measured skirts
/// are defined by them. Error: rounding only, below 1e-6 nm.
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
    size_t i_last, j_last; ///< pieces of the last look-up, from which the next search starts
} sim_surface_t;

/// Read the surface of a report's design or target.
/// @param s            zero-initialised; to be freed in any case
/// @param where, path  dotted path of the surface, and the file, for messages
/// @return             false and *e when something is missing or malformed
bool sim_surface_read(sim_surface_t *s, const cJSON *surface, const char *where, const char *path,
                      common_error_t *e);

/// Look the surface up.
/// @param turn  [turn] drawing's angle, any
/// @param z_mm  any; clamped to the pieces
/// @return      [mm] reduction of the radius
double sim_surface_delta_mm(sim_surface_t *s, double turn, double z_mm);

void sim_surface_free(sim_surface_t *s);

#endif
