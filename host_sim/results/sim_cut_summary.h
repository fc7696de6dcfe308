// SPDX-License-Identifier: Apache-2.0
/// sim_cut_summary: the result of a cut by the firmware, as JSON.
#ifndef SIM_CUT_SUMMARY_H
#define SIM_CUT_SUMMARY_H

#include "sim_cut.h" // sim_cut_t

/// @param cut         not const: the scallop evaluates its design
/// @param table_path  path of the table file
/// @param wall_s      [s] elapsed time on this computer
/// @return            to be freed; NULL when memory is short
char *sim_cut_summary(sim_cut_t *cut, const char *table_path, double wall_s);

#endif
