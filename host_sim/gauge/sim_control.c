// SPDX-License-Identifier: Apache-2.0
#include "sim_control.h"
#include "sim_units.h" // SIM_NM_PER_MM, sim_abs, sim_clamp
#include <math.h>      // sqrt
#include <string.h>    // memset

void sim_control_init(sim_control_t *c, double z_first_mm, double z_last_mm)
{
    memset(c, 0, sizeof *c);
    c->z_first_mm = z_first_mm;
    c->rows_per_mm = sim_work_rows / (z_last_mm - z_first_mm);
}

void sim_control_touch(sim_control_t *c, double turn, double z_mm, double error_mm)
{
    const double error_um = error_mm * 1e3;
    const double height = (z_mm - c->z_first_mm) * c->rows_per_mm;
    const size_t i_row = (size_t)sim_clamp(height, 0.0, sim_work_rows - 1);
    const size_t i_column = (size_t)sim_clamp(turn * sim_work_columns, 0.0, sim_work_columns - 1);
    if (sim_abs(error_um) > c->max_um) {
        c->max_um = sim_abs(error_um);
        c->max_turn = turn;
        c->max_z_mm = z_mm;
    }
    c->sum_um2 += error_um * error_um;
    c->n++;
    sim_row_t *row = &c->row[i_row];
    row->min_um = row->n == 0u || error_um < row->min_um ? error_um : row->min_um;
    row->max_um = row->n == 0u || error_um > row->max_um ? error_um : row->max_um;
    row->n++;
    float *cell_nm = &c->cell_nm[i_row][i_column];
    const double error_nm = error_mm * SIM_NM_PER_MM;
    if (sim_abs(error_nm) > sim_abs((double)*cell_nm)) {
        *cell_nm = (float)error_nm;
    }
}

double sim_control_rms_um(const sim_control_t *c)
{
    return c->n > 0u ? sqrt(c->sum_um2 / (double)c->n) : 0.0;
}

double sim_control_roundness_um(const sim_control_t *c)
{
    double worst_um = 0.0;
    for (size_t i = 0; i < sim_work_rows; i++) {
        const double here_um = c->row[i].max_um - c->row[i].min_um;
        worst_um = here_um > worst_um ? here_um : worst_um;
    }
    return worst_um;
}
