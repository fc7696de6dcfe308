// SPDX-License-Identifier: Apache-2.0
/// sim_nose: tip position of a round nose that just touches the exact surface.
///
///     tip(phi, z_tip) = max over z of  R(phi, z) + sqrt(r^2 - (z - z_tip)^2) - r
///
/// The tip's radius less this one is the error of the part at the contact, whatever was commanded.
/// The maximum is searched over the circle's heights: on equal steps, then by golden section
/// between the neighbours of the best. The search uses no slope of the surface and none of the
/// generator's method. It covers 3 r s to both sides of the tip, s being the steepest slope of 256
/// heights at 24 angles; a contact is within r s. There is no surface beyond the ends of the part:
/// a nose that is beside the part and nearest to its end cuts nothing there. Error below 1e-3 nm on
/// a smooth surface, below 1e-5 sqrt(r) of a kink's angle next to a kink. Source: MATHS.md (107),
/// (110).
#ifndef SIM_NOSE_H
#define SIM_NOSE_H

#include "sim_design.h" // sim_design_t
#include <stdbool.h>    // bool

typedef struct {
    double nose_mm;  ///< radius; 0: the tool has a point
    double reach_mm; ///< largest distance from the tip to a contact
} sim_nose_t;

/// @param nose_mm  radius of the nose, 0 for a point
/// @param design   of a skirt; a table used as the design holds the path of the tip, so the nose
///                 counts as a point
void sim_nose_init(sim_nose_t *n, double nose_mm, sim_design_t *design);

/// @param turn  [turn] angle from the long axis, 0 .. 1
/// @param z_mm  height of the tip, any
/// @param is_beside  set when the nose would touch an end of the part from beside it
/// @return      [mm] radius at which the tip just touches; with a point the radius of the surface
double sim_nose_radius_mm(const sim_nose_t *n, sim_design_t *design, double turn, double z_mm,
                          bool *is_beside);

#endif
