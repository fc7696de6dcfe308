// SPDX-License-Identifier: Apache-2.0
/// sim_map: the surface that is left of the work and the metal that was taken off, as files.
#ifndef SIM_MAP_H
#define SIM_MAP_H

#include "sim_design.h"  // sim_design_t
#include "sim_out.h"     // sim_out_t
#include "sim_removal.h" // sim_slice_t
#include "sim_scallop.h" // sim_scallop_t
#include "sim_session.h" // sim_session_t

/// Write the worst sample of each cell: turn (drawing's angle, 0 .. 1), z_mm, radius_mm, error_nm
/// against the drawing, and with a target control_nm, the cell's largest error against that.
void sim_map_surface(sim_out_t *o, const sim_session_t *s);

/// Write the surface between tracks: turn, z_mm, proud_um above the exact surface; the angles one
/// after the other, heights rising.
void sim_map_scallop(sim_out_t *o, const sim_scallop_t *scallop, sim_design_t *design);

/// Write sections and lines: section (1 .. n; 0: a place of a line), turn, z_mm, radius_mm,
/// deviation_nm against the drawing; places without a pass are left out. A section has its places
/// in the order of rising angles; of lobes that is the direction of the roller, and turn is the
/// polar angle of the profile there.
void sim_map_sections(sim_out_t *o, sim_session_t *s);

void sim_map_removal_header(sim_out_t *o);

/// Write one slice: t_s, turn (drawing's angle, whole turns counted), z_mm,
/// volume_mm3, rate_mm3_s, power_w, rate_force_n, chip_force_n.
void sim_map_removal(sim_out_t *o, const sim_slice_t *slice);

#endif
