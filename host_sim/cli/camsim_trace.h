// SPDX-License-Identifier: Apache-2.0
/// camsim_trace: what each tick did, one line each, and the surface that came of it.
///
/// Trace columns: for reading first, then everything that the firmware's record holds, so that a
/// tick can be replayed. `turn` is the master position (whole turns since the index was found),
/// `faults` the latched faults as a hexadecimal mask in the order of CAM_FAULTS in cam_state.h;
/// true_turn .. error_nm are the machine's truth at the instant of sensing; the rest is named as in
/// cam_trace.h with in_ and out_ for what the tick sensed and wrote. A table that swings the tool
/// has two columns more: the set-point of the swing in force and the true swing, in degrees.
/// Surface columns: turn (0 .. 1 from the long axis in the sense of cutting), z_mm, radius_mm,
/// error_nm.
#ifndef CAMSIM_TRACE_H
#define CAMSIM_TRACE_H

#include "camsim_out.h" // camsim_out_t
#include "sim_cut.h"    // sim_cut_t

void camsim_trace_header(camsim_out_t *o, const sim_cut_t *cut);

/// Write all records that the firmware has made since the last call. After each tick.
void camsim_trace_drain(camsim_out_t *o, sim_cut_t *cut);

void camsim_removal_header(camsim_out_t *o);

/// Write one slice: t_s, turn (spindle angle in the sense of cutting, from the long axis, whole
/// turns counted), z_mm, volume_mm3, rate_mm3_s, power_w, rate_force_n, chip_force_n.
void camsim_removal(camsim_out_t *o, const sim_slice_t *slice);

void camsim_surface(camsim_out_t *o, const sim_work_t *work);

/// Write the surface between tracks: turn, z_mm, proud_um above the exact surface; the angles one
/// after the other, heights rising.
void camsim_scallop(camsim_out_t *o, const sim_scallop_t *scallop, sim_design_t *design);

#endif
