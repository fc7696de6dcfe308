// SPDX-License-Identifier: Apache-2.0
/// sim_nose: where the tip of a round nose stands when the nose just touches the exact surface.
///
///     tip(phi, z_tip) = max over z of  R(phi, z) + sqrt(r^2 - (z - z_tip)^2) - r
///
/// A tip that stands further in has cut too deep by the difference, whatever it was commanded; so
/// tip less this radius is the error of the part where the nose touches it. The largest value is
/// searched among the circle's heights themselves: on equal steps, then between the neighbours of
/// the best one by golden section. No slope of the surface is used, and nothing of the generator's
/// way to the same radius. The search looks 3 r s to both sides of the tip, s the steepest slope of
/// 256 heights at 24 angles; a contact lies within r s. Beyond the ends of the part there is no
/// surface: a nose that comes nearest to the part at an end, from beside it, makes nothing there.
/// Error below 1e-3 nm on a smooth surface, below 1e-5 sqrt(r) of a kink's angle beside a kink.
/// Source: MATHS.md (107), (110).
#ifndef SIM_NOSE_H
#define SIM_NOSE_H

#include "sim_design.h" // sim_design_t
#include <stdbool.h>    // bool

typedef struct {
    double nose_mm;  ///< radius; 0: the tool has a point
    double reach_mm; ///< how far from the tip it may touch
} sim_nose_t;

/// @param nose_mm  radius of the nose, 0 for a point
/// @param design   of a skirt; a table in its place holds the path of the tip itself, so that the
///                 nose counts as a point
void sim_nose_init(sim_nose_t *n, double nose_mm, sim_design_t *design);

/// @param turn  [turn] angle from the long axis, 0 .. 1
/// @param z_mm  height of the tip, any
/// @param is_beside  set to whether the nose would touch an end of the part from beside it
/// @return      [mm] radius at which the tip just touches; with a point the radius of the surface
double sim_nose_radius_mm(const sim_nose_t *n, sim_design_t *design, double turn, double z_mm,
                          bool *is_beside);

#endif
