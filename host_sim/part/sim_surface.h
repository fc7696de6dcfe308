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

#include "common_error.h" // common_error_t
#include "sim_json.h"     // sim_cubics_t
#include <cjson/cJSON.h>
#include <stdbool.h> // bool
#include <stddef.h>  // size_t

// Ovals with parameters over height and possibly different sides.
//
//     delta   = (1 - w) delta_1 + w delta_2
//     delta_s = drop_s + law(phi - phase_s; a - drop_s, G_s)
//     w       = S(1/2 + (pi/2 - |phi - middle|) / blend)
//     S(s)    = s^4 (35 - 84 s + 70 s^2 - 20 s^3)
//
// Laws are those of sim_design.h, and "power": delta = (G / 2) |sin phi|^p, exactly. The table
// plays a polynomial instead near the long axis, and what that costs counts as form error.
// MATHS.md (75) .. (77), independent of the generator's code. Error: rounding.

/// The law of a side.
/// @param parameter  beta or exponent, of a law that has one
/// @param s2         square of the sine of the angle from the long axis
/// @return           [mm] reduction of the radius
typedef double (*sim_law_t)(double parameter, double a_mm, double g_mm, double s2);

typedef struct {
    sim_law_t law_mm;
    sim_cubics_t ovality_mm, drop_mm, parameter, phase_rad; ///< over height
} sim_side_t;

typedef struct {
    int n_sides; ///< 1: the law applies all round
    sim_side_t side[2];
    double middle_rad, blend_rad; ///< of the second side; width of a blending zone
} sim_sides_t;

/// Read "design" of a report.
/// @param s     zero-initialised; the caller frees it, also on failure
/// @param name  of the design, for messages
/// @param path  of the report, for messages
/// @return      false and *e when something is missing or malformed
bool sim_sides_read(sim_sides_t *s, const cJSON *design, const char *name, const char *path,
                    common_error_t *e);

/// @param a_mm     long half axis of the part at this height
/// @param phi_rad  drawing's angle from the long axis, any
/// @param z_mm     any; curves are constant beyond their ends
/// @return         [mm] reduction of the radius
double sim_sides_delta_mm(sim_sides_t *s, double a_mm, double phi_rad, double z_mm);

void sim_sides_free(sim_sides_t *s);

// The surface

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

// The correction of a drawing: what it grows from cold to hot, or a gauged part's errors.
//
//     delta = sum over the orders k of  a_k(z) cos k phi + b_k(z) sin k phi
//
// a_k and b_k are cubics over height, constant beyond their ends; phi is the drawing's angle. A
// gauged part corrects the target of a report, never its design, which judges the part. MATHS.md
// (160), (245). Error: rounding.

enum { sim_correction_max_order = 64 };

typedef struct {
    double order; ///< a whole number, 1 .. sim_correction_max_order
    sim_cubics_t cos_mm, sin_mm;
} sim_wave_t;

typedef struct {
    sim_wave_t *wave; ///< NULL: none
    size_t n;
} sim_correction_t;

/// Read design.correction, if present.
/// @param c     zero-initialised; the caller frees it, also on failure
/// @param name  of the design, for messages
/// @param path  of the report, for messages
/// @return      false and *e when it is malformed
bool sim_correction_read(sim_correction_t *c, const cJSON *design, const char *name,
                         const char *path, common_error_t *e);

/// @param turn  [turn] drawing's angle, any
/// @param z_mm  any
/// @return      [mm] reduction of the radius, 0 without a correction
double sim_correction_delta_mm(sim_correction_t *c, double turn, double z_mm);

void sim_correction_free(sim_correction_t *c);

#endif
