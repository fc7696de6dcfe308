// SPDX-License-Identifier: Apache-2.0
/// sim_trace: one line per tick of a cut, or per several ticks.
///
/// The first columns are for people; the others hold the firmware's whole record, so that a tick
/// can be replayed. `turn` is the master position as the drawing's angle (whole turns since the
/// index was found; falls with M4), `faults` the latched faults as a hexadecimal mask in the order
/// of CAM_FAULTS in cam_state.h; true_turn .. error_nm are the lathe's truth at the instant of
/// sensing; the rest is named as in cam_trace.h, with in_ and out_ for inputs and outputs of the
/// tick. A table that swings the tool adds two columns: the present set-point of the swing and the
/// true swing, in degrees.
#ifndef SIM_TRACE_H
#define SIM_TRACE_H

#include "sim_cut.h" // sim_cut_t
#include "sim_out.h" // sim_out_t

void sim_trace_header(sim_out_t *o, const sim_cut_t *cut);

/// Write all firmware records since the last call. Call it after each tick.
void sim_trace_drain(sim_out_t *o, sim_cut_t *cut);

#endif
