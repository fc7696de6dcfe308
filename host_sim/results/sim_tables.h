// SPDX-License-Identifier: Apache-2.0
/// sim_tables: what a cut by the firmware leaves, as tables of numbers; the columns are listed in
/// sim_tables.c.
///
/// **trace**: one row per tick, or per several. The first columns are for people; the others hold
/// the firmware's whole record. `turn` is the master position as the drawing's angle (its whole
/// turns jump forwards where the index is found; it falls with M4), `faults` the latched faults as
/// a mask in the order of CAM_FAULTS in cam_state.h; true_turn .. error_nm are the lathe's truth at
/// the instant of sensing; the rest is named as in cam_tick.h, with in_ and out_ for inputs and
/// outputs of the tick. A table that swings the tool adds two columns: the present set-point of the
/// swing and the true swing.
///
/// **surface**: the worst sample of each cell: turn (drawing's angle, 0 .. 1), error_nm against the
/// drawing, and with a target control_nm, the cell's largest error against it.
///
/// **removal**: one row per slice of time; whole turns of the drawing's angle are counted.
///
/// **scallop**: the surface between tracks, above the exact surface; by angle, then by height.
///
/// **sections**: sections and lines: section (1 .. n; 0: a point of a line), radius and deviation
/// against the drawing; points without a pass are left out. Points of a section are in order of
/// rising angles; for lobes this is the direction of the roller, and turn is the polar angle of the
/// profile there.
#ifndef SIM_TABLES_H
#define SIM_TABLES_H

#include "sim_cut.h"  // sim_cut_t
#include "sim_rows.h" // sim_rows_t

enum {
    sim_table_trace,
    sim_table_surface,
    sim_table_removal,
    sim_table_scallop,
    sim_table_sections,
    sim_n_tables
};

/// Those that are not wanted have no columns.
typedef struct {
    sim_rows_t rows[sim_n_tables];
} sim_tables_t;

/// Begin the tables of a cut.
/// @param name  of each table's file; NULL: not wanted
void sim_tables_open(sim_tables_t *t, const sim_cut_t *cut, const char *const *name);

/// Append what a tick left to trace and removal. Call it after each tick.
void sim_tables_tick(sim_tables_t *t, sim_cut_t *cut);

/// Make the other tables when the cut has ended.
void sim_tables_end(sim_tables_t *t, sim_cut_t *cut);

void sim_tables_free(sim_tables_t *t);

/// Make the table `surface` of a session by itself.
void sim_tables_surface(sim_rows_t *t, const sim_session_t *s);

#endif
