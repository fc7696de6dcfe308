// SPDX-License-Identifier: Apache-2.0
#include "sim_work.h"
#include "sim_units.h" // SIM_PI, sim_abs
#include <math.h>      // sqrt, remainder, NAN, isfinite
#include <string.h>    // memset

void sim_work_init(sim_work_t *w, double blank_mm, double z_first_mm, double z_last_mm,
                   bool has_map)
{
    memset(w, 0, has_map ? sizeof *w : offsetof(sim_work_t, cell));
    w->has_map = has_map;
    w->blank_mm = blank_mm;
    w->z_first_mm = z_first_mm;
    w->z_last_mm = z_last_mm;
    w->rows_per_mm = sim_work_rows / (z_last_mm - z_first_mm);
}

/// Add a sample to its cell of the map.
static void count_cell(sim_cell_t *cell, double turn, double z_mm, double radius_mm,
                       double error_nm, double slope_um)
{
    if (cell->n == 0u || sim_abs(error_nm) > sim_abs((double)cell->error_nm)) {
        cell->turn = (float)turn;
        cell->z_mm = z_mm;
        cell->radius_mm = radius_mm;
        cell->error_nm = (float)error_nm;
        cell->slope_um = (float)slope_um;
    }
    cell->n += cell->n < UINT32_MAX ? 1u : 0u;
}

/// Add a sample to the sums, its row and its cell of the map.
static void count_error(sim_work_t *w, double turn, double z_mm, double radius_mm, double error_mm,
                        double slope_um)
{
    const double error_um = error_mm * 1e3;
    const double height = (z_mm - w->z_first_mm) * w->rows_per_mm;
    const size_t i_row = (size_t)sim_clamp(height, 0.0, sim_work_rows - 1);
    if (sim_abs(error_um) > w->max_um) {
        w->max_um = sim_abs(error_um);
        w->max_turn = turn;
        w->max_z_mm = z_mm;
    }
    w->sum_um2 += error_um * error_um;
    sim_row_t *row = &w->row[i_row];
    row->min_um = row->n == 0u || error_um < row->min_um ? error_um : row->min_um;
    row->max_um = row->n == 0u || error_um > row->max_um ? error_um : row->max_um;
    row->sum_um2 += error_um * error_um;
    row->n++;
    if (w->has_map) {
        const size_t i_column =
            (size_t)sim_clamp(turn * sim_work_columns, 0.0, sim_work_columns - 1);
        count_cell(&w->cell[i_row][i_column], turn, z_mm, radius_mm, error_mm * SIM_NM_PER_MM,
                   slope_um);
    }
}

/// Add a sample to the sums of the part's orientation. Samples of a turn follow each other closely.
/// @return [um/rad] slope of the drawing, not a number after a gap
static double count_turned(sim_work_t *w, double turn, double exact_mm, double error_mm)
{
    const double by_turn = remainder(turn - w->last_turn, 1.0);
    double mean_um = NAN; // slope in the middle between this sample and the last one
    if (w->n > 0u && by_turn != 0.0 && sim_abs(by_turn) < 0.1) {
        mean_um = 1e3 * (exact_mm - w->last_exact_mm) / (SIM_TWO_PI * by_turn);
    }
    const double slope_um = mean_um + 0.5 * (mean_um - w->last_slope_um);
    if (isfinite(slope_um)) {
        w->turned_um2 += 1e3 * error_mm * slope_um;
        w->slope_um2 += slope_um * slope_um;
    }
    w->last_turn = turn;
    w->last_exact_mm = exact_mm;
    w->last_slope_um = mean_um;
    return slope_um;
}

void sim_work_judge(sim_work_t *w, double turn, double z_mm, double radius_mm, double exact_mm,
                    bool is_counted)
{
    const double error_mm = radius_mm - exact_mm;
    // A gouge stays in the part, so engaging and disengaging count, too.
    if (-error_mm * 1e3 > w->gouge_um && z_mm >= w->z_first_mm && z_mm <= w->z_last_mm) {
        w->gouge_um = -error_mm * 1e3;
    }
    if (!is_counted) {
        return;
    }
    const double depth_mm = w->blank_mm - radius_mm;
    const bool is_first = w->n == 0u;
    w->depth_min_mm = is_first || depth_mm < w->depth_min_mm ? depth_mm : w->depth_min_mm;
    w->depth_max_mm = is_first || depth_mm > w->depth_max_mm ? depth_mm : w->depth_max_mm;
    const double slope_um = count_turned(w, turn, exact_mm, error_mm);
    count_error(w, turn, z_mm, radius_mm, error_mm, slope_um);
    w->n++;
}

void sim_work_remove(sim_work_t *w, double z_mm, double radius_mm, bool is_counted)
{
    if (!is_counted) {
        return;
    }
    const double fed_mm = w->n == 0u ? 0.0 : sim_abs(z_mm - w->last_z_mm);
    const double depth_mm = w->blank_mm - radius_mm;
    // Ring area pi (R^2 - r^2) = pi (R - r) (R + r); its height is the feed since the last sample.
    w->removed_mm3 += SIM_PI * depth_mm * (w->blank_mm + radius_mm) * fed_mm;
    w->last_z_mm = z_mm;
}

double sim_work_turned_rad(const sim_work_t *w)
{
    return w->slope_um2 > 0.0 ? w->turned_um2 / w->slope_um2 : 0.0;
}

double sim_work_shape_rms_um(const sim_work_t *w)
{
    const double left_um2 = w->sum_um2 - w->turned_um2 * sim_work_turned_rad(w);
    return w->n > 0u && left_um2 > 0.0 ? sqrt(left_um2 / (double)w->n) : 0.0;
}

double sim_work_shape_max_um(const sim_work_t *w)
{
    const double turned_rad = sim_work_turned_rad(w);
    double max_um = 0.0;
    for (size_t i = 0; w->has_map && i < (size_t)sim_work_rows * sim_work_columns; i++) {
        const sim_cell_t *cell = &w->cell[i / sim_work_columns][i % sim_work_columns];
        const double turned_um = turned_rad * (double)cell->slope_um;
        const double left_um = sim_abs(1e-3 * (double)cell->error_nm - turned_um);
        max_um = left_um > max_um ? left_um : max_um; // not where the slope is not known
    }
    return max_um;
}

double sim_work_rms_um(const sim_work_t *w)
{
    return w->n > 0u ? sqrt(w->sum_um2 / (double)w->n) : 0.0;
}

double sim_work_roundness_um(const sim_work_t *w)
{
    double worst_um = 0.0;
    for (size_t i = 0; i < sim_work_rows; i++) {
        const double here_um = w->row[i].max_um - w->row[i].min_um;
        worst_um = here_um > worst_um ? here_um : worst_um;
    }
    return worst_um;
}
