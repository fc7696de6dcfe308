// SPDX-License-Identifier: Apache-2.0
#include "sim_map.h"
#include "sim_units.h" // SIM_NM_PER_MM
#include <math.h>      // isnan

void sim_map_removal_header(sim_out_t *o)
{
    sim_out_text(o, "t_s,turn,z_mm,volume_mm3,rate_mm3_s,power_w,rate_force_n,chip_force_n\n");
}

void sim_map_removal(sim_out_t *o, const sim_slice_t *slice)
{
    sim_out_real(o, slice->t_s, 9);
    sim_out_real_column(o, slice->turn, 9);
    sim_out_real_column(o, slice->z_mm, 6);
    sim_out_real_column(o, slice->volume_mm3, 9);
    sim_out_real_column(o, slice->rate_mm3_s, 6);
    sim_out_real_column(o, slice->power_w, 6);
    sim_out_real_column(o, slice->rate_force_n, 6);
    sim_out_real_column(o, slice->chip_force_n, 6);
    sim_out_char(o, '\n');
}

void sim_map_surface(sim_out_t *o, const sim_session_t *s)
{
    const sim_work_t *work = &s->work;
    sim_out_text(o, s->has_target ? "turn,z_mm,radius_mm,error_nm,control_nm\n"
                                  : "turn,z_mm,radius_mm,error_nm\n");
    for (int i = 0; i < sim_work_rows; i++) {
        for (int k = 0; k < sim_work_columns; k++) {
            const sim_cell_t *cell = &work->cell[i][k];
            if (cell->n > 0u) {
                sim_out_real(o, (double)cell->turn, 8);
                sim_out_real_column(o, cell->z_mm, 6);
                sim_out_real_column(o, cell->radius_mm, 9);
                sim_out_real_column(o, (double)cell->error_nm, 3);
                if (s->has_target) {
                    sim_out_real_column(o, (double)s->control.cell[i][k].error_nm, 3);
                }
                sim_out_char(o, '\n');
            }
        }
    }
}

void sim_map_scallop(sim_out_t *o, const sim_scallop_t *scallop, sim_design_t *design)
{
    sim_out_text(o, "turn,z_mm,proud_um\n");
    for (int i = 0; i < sim_scallop_angles; i++) {
        for (int j = 0; j < sim_scallop_heights; j++) {
            sim_out_real(o, (double)i / sim_scallop_angles, 8);
            sim_out_real_column(o, sim_scallop_height_mm(scallop, j), 6);
            sim_out_real_column(o, sim_scallop_proud_um(scallop, design, i, j), 6);
            sim_out_char(o, '\n');
        }
    }
}

static void write_place(sim_out_t *o, int section, double turn, double z_mm, double drawn_mm,
                        double e_mm)
{
    sim_out_integer(o, section);
    sim_out_real_column(o, turn, 8);
    sim_out_real_column(o, z_mm, 6);
    sim_out_real_column(o, drawn_mm + e_mm, 9);
    sim_out_real_column(o, e_mm * SIM_NM_PER_MM, 3);
    sim_out_char(o, '\n');
}

static void write_line(sim_out_t *o, sim_session_t *s, int line)
{
    const double turn = (double)line / sim_sections_lines;
    for (int i = 0; i < sim_sections_heights; i++) {
        const double e_mm = s->sections.line_e_mm[line][i];
        const double z_mm = sim_sections_height_mm(&s->sections, i);
        if (!isnan(e_mm)) {
            write_place(o, 0, turn, z_mm, sim_design_radius_mm(&s->design, turn, z_mm), e_mm);
        }
    }
}

static void write_section(sim_out_t *o, sim_session_t *s, int section)
{
    const bool has_lobes = s->design.shape == sim_shape_lobes;
    const double z_mm = s->sections.z_mm[section];
    for (int i = 0; i < sim_sections_places; i++) {
        const sim_place_t *at = &s->sections.section[section][i];
        const double turn = has_lobes ? at->turn : (double)i / sim_sections_places;
        if (!isnan(at->e_mm)) {
            write_place(o, section + 1, turn, z_mm,
                        has_lobes ? at->drawn_mm : sim_design_radius_mm(&s->design, turn, z_mm),
                        at->e_mm);
        }
    }
}

void sim_map_sections(sim_out_t *o, sim_session_t *s)
{
    sim_out_text(o, "section,turn,z_mm,radius_mm,deviation_nm\n");
    for (int i = 0; i < s->sections.n; i++) {
        write_section(o, s, i);
    }
    for (int i = 0; i < sim_sections_lines && s->design.shape != sim_shape_lobes; i++) {
        write_line(o, s, i);
    }
}
