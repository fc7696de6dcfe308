// SPDX-License-Identifier: Apache-2.0
#include "sim_work.h"
#include "sim_units.h" // sim_abs, sim_clamp
#include <math.h>      // sqrt

/// [mm] heights this close to an end of the part count as the end.
#define END_MM 1e-4

enum { n_heights = 256, n_angles = 24, n_steps = 16, max_cuts = 60 };

/// The tip, for a nose that touches at one height.
typedef struct {
    const sim_nose_t *nose;
    sim_design_t *design;
    double turn, tip_z_mm;
} place_t;

static double tip_mm(const place_t *p, double z_mm)
{
    const double r_mm = p->nose->nose_mm;
    const double off_mm = z_mm - p->tip_z_mm;
    const double inner_mm2 = r_mm * r_mm - off_mm * off_mm;
    const double root_mm = inner_mm2 > 0.0 ? sqrt(inner_mm2) : 0.0;
    // root - r without cancellation
    return sim_design_radius_mm(p->design, p->turn, z_mm) - off_mm * off_mm / (r_mm + root_mm);
}

static double steepest(sim_design_t *design)
{
    const double step_mm = (design->z_last_mm - design->z_first_mm) / n_heights;
    double worst = 0.0;
    for (int k = 0; k < n_angles; k++) {
        const double turn = (double)k / n_angles;
        double last_mm = sim_design_radius_mm(design, turn, design->z_first_mm);
        for (int i = 1; i <= n_heights; i++) {
            const double here_mm =
                sim_design_radius_mm(design, turn, design->z_first_mm + i * step_mm);
            const double slope = sim_abs(here_mm - last_mm) / step_mm;
            worst = slope > worst ? slope : worst;
            last_mm = here_mm;
        }
    }
    return worst;
}

void sim_nose_init(sim_nose_t *n, double nose_mm, sim_design_t *design)
{
    *n = (sim_nose_t){0};
    if (nose_mm <= 0.0 || design->shape == sim_shape_table || design->shape == sim_shape_lobes) {
        return;
    }
    const double least = 1e-4; // for a cylinder
    const double slope = 3.0 * steepest(design) + least;
    *n = (sim_nose_t){.nose_mm = nose_mm, .reach_mm = nose_mm * (slope < 1.0 ? slope : 1.0)};
}

/// Find the maximum between two heights, where there is only one.
static double golden_mm(const place_t *p, double low_mm, double high_mm, double *at_mm)
{
    const double golden = 0.61803398874989484820;
    const double near_mm = 1e-5 * sqrt(p->nose->nose_mm);
    double z_mm[2] = {high_mm - golden * (high_mm - low_mm), low_mm + golden * (high_mm - low_mm)};
    double found_mm[2] = {tip_mm(p, z_mm[0]), tip_mm(p, z_mm[1])};
    for (int i = 0; i < max_cuts && high_mm - low_mm > near_mm; i++) {
        const int kept = found_mm[0] > found_mm[1] ? 0 : 1;
        low_mm = kept == 0 ? low_mm : z_mm[0];
        high_mm = kept == 0 ? z_mm[1] : high_mm;
        const double width_mm = golden * (high_mm - low_mm);
        z_mm[1 - kept] = z_mm[kept];
        found_mm[1 - kept] = found_mm[kept];
        z_mm[kept] = kept == 0 ? high_mm - width_mm : low_mm + width_mm;
        found_mm[kept] = tip_mm(p, z_mm[kept]);
    }
    const int best = found_mm[0] > found_mm[1] ? 0 : 1;
    *at_mm = z_mm[best];
    return found_mm[best];
}

double sim_nose_radius_mm(const sim_nose_t *n, sim_design_t *design, double turn, double z_mm,
                          bool *is_beside)
{
    *is_beside = false;
    if (n->nose_mm <= 0.0) {
        return sim_design_radius_mm(design, turn, z_mm);
    }
    double first_mm;
    double last_mm;
    sim_design_ends(design, z_mm, &first_mm, &last_mm);
    const place_t place = {n, design, turn, sim_clamp(z_mm, first_mm, last_mm)};
    const double low_mm = sim_clamp(z_mm - n->reach_mm, first_mm, last_mm);
    const double high_mm = sim_clamp(z_mm + n->reach_mm, first_mm, last_mm);
    const double step_mm = (high_mm - low_mm) / n_steps;
    int best = 0;
    double best_mm = tip_mm(&place, low_mm);
    for (int i = 1; i <= n_steps; i++) {
        const double here_mm = tip_mm(&place, low_mm + i * step_mm);
        best = here_mm > best_mm ? i : best;
        best_mm = here_mm > best_mm ? here_mm : best_mm;
    }
    const int below = best > 0 ? best - 1 : 0;
    const int above = best < n_steps ? best + 1 : n_steps;
    double at_mm;
    const double found_mm =
        golden_mm(&place, low_mm + below * step_mm, low_mm + above * step_mm, &at_mm);
    at_mm = found_mm > best_mm ? at_mm : low_mm + best * step_mm;
    *is_beside = at_mm < first_mm + END_MM || at_mm > last_mm - END_MM;
    return found_mm > best_mm ? found_mm : best_mm;
}
