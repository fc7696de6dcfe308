// SPDX-License-Identifier: Apache-2.0
/// sim_cut_pass: the passes of a cut, one after the other, each gauged against the drawing and the
/// stock that it has to leave.
///
/// The operator starts the next pass when the controller is ready and has made it the next one. The
/// metal that a pass removes is what the pass before has to leave, exactly; the first one turns the
/// cylinder of the blank. Source: MATHS.md (105).
#ifndef SIM_CUT_PASS_H
#define SIM_CUT_PASS_H

#include "sim_cut.h" // sim_cut_t
#include <stdbool.h> // bool

/// Prepare the first pass, once the parameters are known.
void sim_cut_first_pass(sim_cut_t *cut);

/// Derive slices and speed of the pass that is cut.
void sim_cut_plan_pass(sim_cut_t *cut);

/// @return whether another pass follows the one that has ended
bool sim_cut_has_next_pass(const sim_cut_t *cut);

/// Keep the results of the pass that has ended, and prepare the next one when the controller has
/// made it the next. While it has not, nothing changes.
void sim_cut_next_pass(sim_cut_t *cut);

/// @return results of the pass that is being cut, or was the last one
sim_pass_result_t sim_cut_pass_result(const sim_cut_t *cut);

/// @return [s] machine time that all passes should take, engaging and disengaging included
double sim_cut_planned_s(const sim_cut_t *cut);

/// @return [turn] length of the cutting state in all passes together, as planned
double sim_cut_planned_in_all(const sim_cut_t *cut);

/// @return whether no pass before the last one has cut deeper than the drawing allows
bool sim_cut_left_stock(const sim_cut_t *cut);

#endif
