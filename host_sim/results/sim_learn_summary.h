// SPDX-License-Identifier: Apache-2.0
/// sim_learn_summary: the controller's learning and the convergence of the error, as JSON.
///
///     "error_per_turn_um": [..]            per turn: rehearsal, then cut (sim_work.h)
///     "error_per_turn": {"turn", "state"}  start of each; "rehearsing" or "cutting"
///     "learning": is_on, phase, reason, turns, masked, k1_ns, k2_us2, harmonics, ...
#ifndef SIM_LEARN_SUMMARY_H
#define SIM_LEARN_SUMMARY_H

#include "sim_cut.h" // sim_cut_t
#include <cjson/cJSON.h>

void sim_learn_summary(cJSON *root, sim_cut_t *cut);

#endif
