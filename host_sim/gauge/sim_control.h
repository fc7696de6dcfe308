// SPDX-License-Identifier: Apache-2.0
/// sim_control: the controller's own error, apart from what its table deliberately changes.
///
///     error = radius of the tool tip - radius of the target at the tool's true angle and height
///
/// The target is the refit of a corner or the filter of a measured section: what the table plays.
/// The same rows and cells as those of sim_work.h, which judges against the drawing.
#ifndef SIM_CONTROL_H
#define SIM_CONTROL_H

#include "sim_work.h" // sim_row_t, sim_work_rows

typedef struct {
    double max_um, sum_um2;    ///< largest magnitude, sum of squares
    double max_turn, max_z_mm; ///< place of the largest
    double z_first_mm, rows_per_mm;
    uint64_t n;
    sim_row_t row[sim_work_rows];
    float cell_nm[sim_work_rows][sim_work_columns]; ///< largest of each cell
} sim_control_t;

/// @param c  0.8 MB: allocate it
void sim_control_init(sim_control_t *c, double z_first_mm, double z_last_mm);

/// Take a sample that is judged. @param turn  [turn] drawing's angle, 0 .. 1
void sim_control_touch(sim_control_t *c, double turn, double z_mm, double error_mm);

/// @return [um] rms error, 0 without samples
double sim_control_rms_um(const sim_control_t *c);

/// @return [um] largest roundness of all rows, 0 without samples
double sim_control_roundness_um(const sim_control_t *c);

#endif
