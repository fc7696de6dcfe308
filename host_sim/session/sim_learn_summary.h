// SPDX-License-Identifier: Apache-2.0
/// sim_learn_summary: what the controller learned, and how the error converged, as JSON.
///
///     "error_per_turn_um": [..]        of each turn: the rehearsal's, then the cut's (sim_turns.h)
///     "error_per_turn": {"turn", "state"}  where each began, and whether "rehearsing" or "cutting"
///     "learning": is_on, phase, reason, turns, masked, k1_ns, k2_us2, harmonics, ...
#ifndef SIM_LEARN_SUMMARY_H
#define SIM_LEARN_SUMMARY_H

#include "sim_cut.h" // sim_cut_t
#include <cjson/cJSON.h>

void sim_learn_summary(cJSON *root, sim_cut_t *cut);

#endif
