// SPDX-License-Identifier: Apache-2.0
/// sim_sides: ovals with parameters over height and possibly different sides.
///
///     delta   = (1 - w) delta_1 + w delta_2
///     delta_s = drop_s + law(phi - phase_s; a - drop_s, G_s)
///     w       = S(1/2 + (pi/2 - |phi - middle|) / blend)
///     S(s)    = s^4 (35 - 84 s + 70 s^2 - 20 s^3)
///
/// Laws are those of sim_design.h, and "power": delta = (G / 2) |sin phi|^p, exactly. The table
/// plays a polynomial instead near the long axis, and what that costs counts as form error.
/// MATHS.md (75)
/// .. (77), independent of the generator's code. Error: rounding.
#ifndef SIM_SIDES_H
#define SIM_SIDES_H

#include "common_error.h" // common_error_t
#include "sim_cubics.h"   // sim_cubics_t
#include <cjson/cJSON.h>
#include <stdbool.h> // bool

/// The law of one side, in the order of their names in NAME.json.
typedef enum {
    sim_law_ellipse,
    sim_law_cosine,
    sim_law_double_ellipse,
    sim_law_power,
    sim_n_laws,
} sim_law_t;

typedef struct {
    sim_law_t law;
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

#endif
