// SPDX-License-Identifier: Apache-2.0
/// sim_watch_out: trace and summary of a cut on a bus.
///
/// Trace: one row per period, columns as in a run (sim_tables.h) first (`state` and `faults` as
/// last reported by the controller, "-" and 0 before), then
///     true_turn,true_z_mm,radius_mm,error_nm   the truth at the SYNC
///     enable,fault,in_cut                      lines of the controller
///     syncs                                    number of SYNCs so far
///     encoder_counts                           last sent before the SYNC
///     A_control,A_status,A_target,A_actual,A_offset for A = u, x, z, spindle; control and status
///     words in hexadecimal; the spindle without offset, with speeds in r/min / 1000
#ifndef SIM_WATCH_OUT_H
#define SIM_WATCH_OUT_H

#include "sim_rows.h"  // sim_rows_t
#include "sim_watch.h" // sim_watch_t

extern const char sim_watch_trace_columns[];

/// Append the row of the last period.
void sim_watch_trace_row(sim_rows_t *t, const sim_watch_t *w);

/// Print the JSON summary. @return to be freed; NULL when memory is short
char *sim_watch_summary(const sim_watch_t *w);

#endif
