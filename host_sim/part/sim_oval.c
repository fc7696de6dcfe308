// SPDX-License-Identifier: Apache-2.0
#include "sim_design.h"
#include <math.h> // sqrt

double sim_design_delta_mm(sim_shape_t shape, double beta, double a_mm, double g_mm, double s2)
{
    if (shape == sim_shape_cosine) {
        return 0.5 * g_mm * s2;
    }
    if (shape == sim_shape_double_ellipse) { // 1 - cos 2p = 2 s2, 1 - cos 4p = 8 s2 (1 - s2)
        return 0.5 * g_mm * s2 * (1.0 + beta * 0.16 * (1.0 - s2));
    }
    const double b_mm = a_mm - 0.5 * g_mm;
    const double k = 0.5 * g_mm * (a_mm + b_mm) / (b_mm * b_mm);
    const double q = sqrt(1.0 + k * s2);
    return a_mm * k * s2 / (q * (q + 1.0));
}

sim_arc_t sim_arc_of(double a_mm, double g_mm, double trim_mm, double at_joint_mm, double sin_joint)
{
    const double p_mm = a_mm - at_joint_mm;
    const double b_mm = a_mm - 0.5 * g_mm - trim_mm;
    const double fall_mm = 0.5 * g_mm + trim_mm - at_joint_mm; // P - B without cancellation
    const double e_mm = fall_mm * (p_mm + b_mm) / (2.0 * (b_mm - p_mm * sin_joint));
    return (sim_arc_t){.eccentricity_mm = e_mm, .radius_mm = b_mm + e_mm};
}

double sim_arc_radius_mm(const sim_arc_t *arc, double sin_phi)
{
    const double e = arc->eccentricity_mm;
    const double cos2 = 1.0 - sin_phi * sin_phi;
    return sqrt(arc->radius_mm * arc->radius_mm - e * e * cos2) - e * sin_phi;
}
