// SPDX-License-Identifier: Apache-2.0
/// sim_map: output files for the cut surface and the removed metal.
#ifndef SIM_MAP_H
#define SIM_MAP_H

#include "sim_design.h"  // sim_design_t
#include "sim_out.h"     // sim_out_t
#include "sim_removal.h" // sim_slice_t
#include "sim_scallop.h" // sim_scallop_t
#include "sim_session.h" // sim_session_t

/// Write the worst sample of each cell: turn (drawing's angle, 0 .. 1), z_mm, radius_mm, error_nm
/// against the drawing, and with a target control_nm, the cell's largest error against it.
void sim_map_surface(sim_out_t *o, const sim_session_t *s);

/// Write the surface between tracks: turn, z_mm, proud_um above the exact surface; by angle, then
/// by rising height.
void sim_map_scallop(sim_out_t *o, const sim_scallop_t *scallop, sim_design_t *design);

/// Write sections and lines: section (1 .. n; 0: a point of a line), turn, z_mm, radius_mm,
/// deviation_nm against the drawing; points without a pass are left out. Points of a section are in
/// order of rising angles; for lobes this is the direction of the roller, and turn is the polar
/// angle of the profile there.
void sim_map_sections(sim_out_t *o, sim_session_t *s);

void sim_map_removal_header(sim_out_t *o);

/// Write one slice: t_s, turn (drawing's angle, whole turns counted), z_mm,
/// volume_mm3, rate_mm3_s, power_w, rate_force_n, chip_force_n.
void sim_map_removal(sim_out_t *o, const sim_slice_t *slice);

#endif
