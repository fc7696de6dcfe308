// SPDX-License-Identifier: Apache-2.0
/// sim_arc: a section of an oval and an eccentric circle, with their corner, MATHS.md (10), (11).
///
///     phi < joint    the oval, reduction delta(phi)
///     phi >= joint   rho = sqrt(R^2 - e^2 cos^2 phi) - e sin phi,  R = B + e
///     P = a - delta(joint),  B = a - G/2 - trim,  e = (P - B) (P + B) / (2 (B - P sin joint))
///
/// phi is folded into the first quadrant. Error: rounding only, below 1e-6 nm.
#ifndef SIM_ARC_H
#define SIM_ARC_H

typedef struct {
    double eccentricity_mm, radius_mm;
} sim_arc_t;

/// Derive the circle that meets the oval at the joint and is `trim` below it on the short axis.
/// @param at_joint_mm  reduction of the oval at the joint
/// @param sin_joint    sine of the joint's angle
sim_arc_t sim_arc_of(double a_mm, double g_mm, double trim_mm, double at_joint_mm,
                     double sin_joint);

/// @return [mm] distance of the circle from the centre of the part; sin_phi 0 .. 1
double sim_arc_radius_mm(const sim_arc_t *arc, double sin_phi);

#endif
