// SPDX-License-Identifier: Apache-2.0
/// camsim_summary: what came of a cut, as JSON and as text.
///
/// All of it is the same for the same input and seed, but wall_time_s and ticks_per_s.
#ifndef CAMSIM_SUMMARY_H
#define CAMSIM_SUMMARY_H

#include "camsim.h"     // camsim_options_t
#include "camsim_out.h" // camsim_out_t
#include "sim_cut.h"    // sim_cut_t

/// Write the JSON summary. @return false when memory is short
/// @param cut  looks its design up
bool camsim_summary_json(camsim_out_t *o, const camsim_options_t *options, sim_cut_t *cut,
                         double wall_s);

/// Print the essentials to standard output.
void camsim_summary_text(const camsim_options_t *options, const sim_cut_t *cut, double wall_s);

/// @return "done", "stopped", "fault", "timeout" or "refused"
const char *camsim_summary_end(const sim_cut_t *cut);

/// @return true when the cut ended well, all of it was gauged, and the form error is within the
///         tolerance
bool camsim_summary_is_good(const camsim_options_t *options, const sim_cut_t *cut);

#endif
