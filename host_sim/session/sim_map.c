// SPDX-License-Identifier: Apache-2.0
#include "sim_map.h"

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
