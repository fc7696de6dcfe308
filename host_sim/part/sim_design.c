// SPDX-License-Identifier: Apache-2.0
#include "sim_design.h"
#include "sim_units.h" // sim_sine, SIM_TWO_PI
#include <math.h>      // fabs

static void look_up_arc(sim_design_t *d, double z_mm)
{
    d->sin_joint = sim_sine(sim_cubics_at(&d->joint_turn, z_mm));
    const double s2 = d->sin_joint * d->sin_joint;
    const double at_joint_mm = sim_design_delta_mm(d->oval, d->beta, d->a_mm, d->g_mm, s2);
    d->arc =
        sim_arc_of(d->a_mm, d->g_mm, sim_cubics_at(&d->trim_mm, z_mm), at_joint_mm, d->sin_joint);
}

static void look_up(sim_design_t *d, double z_mm)
{
    if (z_mm != d->at_z_mm) {
        d->a_mm = sim_cubics_at(&d->radius_mm, z_mm);
        d->g_mm = d->ovality_mm.n > 0u ? sim_cubics_at(&d->ovality_mm, z_mm) : 0.0;
        if (d->shape == sim_shape_arc) {
            look_up_arc(d, z_mm);
        }
        d->at_z_mm = z_mm;
    }
}

/// @return [mm] radius without the correction, after look_up()
static double drawn_mm(sim_design_t *d, double turn, double z_mm)
{
    const double phase_rad = d->is_turned ? sim_cubics_at(&d->phase_rad, z_mm) : 0.0;
    const double drawn = turn - phase_rad / SIM_TWO_PI;
    if (d->shape == sim_shape_surface) {
        return d->a_mm - sim_surface_delta_mm(&d->surface, drawn, z_mm);
    }
    if (d->shape == sim_shape_sides) {
        return d->a_mm - sim_sides_delta_mm(&d->sides, d->a_mm, SIM_TWO_PI * drawn, z_mm);
    }
    const double s = fabs(sim_sine(drawn));
    if (d->shape == sim_shape_arc) {
        return s < d->sin_joint
                   ? d->a_mm - sim_design_delta_mm(d->oval, d->beta, d->a_mm, d->g_mm, s * s)
                   : sim_arc_radius_mm(&d->arc, s);
    }
    return d->a_mm - sim_design_delta_mm(d->shape, d->beta, d->a_mm, d->g_mm, s * s);
}

double sim_design_radius_mm(sim_design_t *d, double turn, double z_mm)
{
    if (d->shape == sim_shape_table) {
        return sim_design_table_radius_mm(d->table, turn, z_mm);
    }
    look_up(d, z_mm);
    return drawn_mm(d, turn, z_mm) - sim_correction_delta_mm(&d->correction, turn, z_mm);
}

double sim_design_long_mm(sim_design_t *d, double z_mm)
{
    if (d->shape == sim_shape_table) {
        return sim_design_table_long_mm(d->table, z_mm);
    }
    look_up(d, z_mm);
    return d->a_mm;
}

double sim_design_find_largest_mm(sim_design_t *d)
{
    enum { n_samples = 4096 };
    double largest_mm = 0.0;
    for (int i = 0; i <= n_samples; i++) {
        const double part = (double)i / n_samples;
        const double z_mm = d->z_first_mm + part * (d->z_last_mm - d->z_first_mm);
        const double a_mm = sim_design_long_mm(d, z_mm);
        largest_mm = a_mm > largest_mm ? a_mm : largest_mm;
    }
    return largest_mm;
}

bool sim_design_is_on_part(const sim_design_t *d, double z_mm)
{
    return (!d->is_run_into || z_mm >= d->z_first_mm) &&
           (!d->is_run_out_of || z_mm <= d->z_last_mm);
}

void sim_design_ends(const sim_design_t *d, double z_mm, double *first_mm, double *last_mm)
{
    *first_mm = d->z_first_mm;
    *last_mm = d->z_last_mm;
    for (int i = 0; i < d->bands.n; i++) {
        const sim_band_t *band = &d->bands.band[i];
        if (z_mm >= band->low_mm && z_mm <= band->high_mm) {
            *first_mm = band->low_mm;
            *last_mm = band->high_mm;
        }
    }
}

void sim_design_free(sim_design_t *d)
{
    sim_cubics_free(&d->radius_mm);
    sim_cubics_free(&d->ovality_mm);
    sim_cubics_free(&d->trim_mm);
    sim_cubics_free(&d->joint_turn);
    sim_cubics_free(&d->phase_rad);
    sim_surface_free(&d->surface);
    sim_sides_free(&d->sides);
    sim_lobe_design_free(&d->lobes);
    sim_correction_free(&d->correction);
    sim_areas_free(&d->areas);
}
