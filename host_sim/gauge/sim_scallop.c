// SPDX-License-Identifier: Apache-2.0
#include "sim_scallop.h"
#include "sim_units.h" // sim_fraction
#include <math.h>      // ceil, sqrt

void sim_scallop_init(sim_scallop_t *s, double nose_mm, double z_first_mm, double z_last_mm,
                      double blank_mm)
{
    s->nose_mm = nose_mm;
    s->z_first_mm = z_first_mm;
    s->z_last_mm = z_last_mm;
    s->has_last = false;
    for (int i = 0; i < sim_scallop_angles && nose_mm > 0.0; i++) {
        for (int j = 0; j < sim_scallop_heights; j++) {
            s->left_mm[i][j] = blank_mm;
        }
    }
}

double sim_scallop_height_mm(const sim_scallop_t *s, int height)
{
    const double share = (double)height / (sim_scallop_heights - 1);
    return s->z_first_mm + share * (s->z_last_mm - s->z_first_mm);
}

/// Cut with the circle of the nose at one angle.
static void cut(sim_scallop_t *s, int angle, double z_mm, double tip_mm)
{
    const double nose_mm = s->nose_mm;
    for (int j = 0; j < sim_scallop_heights; j++) {
        const double off_mm = sim_scallop_height_mm(s, j) - z_mm;
        const double inner_mm2 = nose_mm * nose_mm - off_mm * off_mm;
        const double cut_mm = tip_mm + nose_mm - sqrt(inner_mm2 > 0.0 ? inner_mm2 : 0.0);
        double *left_mm = &s->left_mm[angle][j];
        *left_mm = inner_mm2 > 0.0 && cut_mm < *left_mm ? cut_mm : *left_mm;
    }
}

/// Cut at all angles of the map between two samples; `from` has the smaller angle.
static void pass(sim_scallop_t *s, sim_design_t *design, const sim_scallop_tip_t *from,
                 const sim_scallop_tip_t *to, double turned)
{
    const int first = (int)ceil(from->turn * sim_scallop_angles);
    const int n = (int)ceil((from->turn + turned) * sim_scallop_angles) - first;
    for (int i = 0; i < n; i++) {
        const double share = ((double)(first + i) / sim_scallop_angles - from->turn) / turned;
        const double here_mm = from->z_mm + share * (to->z_mm - from->z_mm);
        const double here_proud_mm = from->proud_mm + share * (to->proud_mm - from->proud_mm);
        const int angle = (first + i) % sim_scallop_angles;
        const double exact_mm =
            sim_design_radius_mm(design, (double)angle / sim_scallop_angles, here_mm);
        cut(s, angle, here_mm, exact_mm + here_proud_mm);
    }
}

void sim_scallop_touch(sim_scallop_t *s, sim_design_t *design, double turn, double z_mm,
                       double radius_mm)
{
    const bool is_near = z_mm > s->z_first_mm - s->nose_mm && z_mm < s->z_last_mm + s->nose_mm;
    if (s->nose_mm <= 0.0 || !is_near) {
        s->has_last = false;
        return;
    }
    const double proud_mm = radius_mm - sim_design_radius_mm(design, turn, z_mm);
    const sim_scallop_tip_t now = {.turn = turn, .z_mm = z_mm, .proud_mm = proud_mm};
    const double turned = sim_fraction(turn - s->last.turn);
    if (s->has_last && turned > 0.0 && turned < 0.5) {
        pass(s, design, &s->last, &now, turned);
    } else if (s->has_last && turned > 0.5) { // M4 counts down
        pass(s, design, &now, &s->last, 1.0 - turned);
    }
    s->has_last = true;
    s->last = now;
}

double sim_scallop_proud_um(const sim_scallop_t *s, sim_design_t *design, int angle, int height)
{
    const double turn = (double)angle / sim_scallop_angles;
    const double exact_mm = sim_design_radius_mm(design, turn, sim_scallop_height_mm(s, height));
    return (s->left_mm[angle][height] - exact_mm) * 1e3;
}

sim_scallop_figures_t sim_scallop_figures(const sim_scallop_t *s, sim_design_t *design)
{
    sim_scallop_figures_t f = {0};
    for (int i = 0; i < sim_scallop_angles; i++) {
        double peak_um = sim_scallop_proud_um(s, design, i, 0);
        double valley_um = peak_um;
        for (int j = 0; j < sim_scallop_heights; j++) {
            const double here_um = sim_scallop_proud_um(s, design, i, j);
            peak_um = here_um > peak_um ? here_um : peak_um;
            valley_um = here_um < valley_um ? here_um : valley_um;
            f.mean_um += here_um / (sim_scallop_angles * sim_scallop_heights);
        }
        const double deep_um = peak_um - valley_um;
        f.highest_um = i == 0 || deep_um > f.highest_um ? deep_um : f.highest_um;
        f.lowest_um = i == 0 || deep_um < f.lowest_um ? deep_um : f.lowest_um;
    }
    return f;
}
