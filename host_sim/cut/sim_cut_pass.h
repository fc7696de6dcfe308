// SPDX-License-Identifier: Apache-2.0
/// sim_cut_pass: the passes of a cut, each gauged against the drawing plus the stock that it has to
/// leave.
///
/// The operator starts a pass when the controller is ready and has selected it. A pass removes
/// exactly the stock that the pass before has to leave; the first pass turns the cylindrical blank.
/// Source: MATHS.md (105).
#ifndef SIM_CUT_PASS_H
#define SIM_CUT_PASS_H

#include "sim_cut.h" // sim_cut_t
#include <stdbool.h> // bool

/// Prepare the first pass, once the parameters are known.
void sim_cut_first_pass(sim_cut_t *cut);

/// Place the window of the surface between tracks for the feed of the present pass.
/// @return false and *e when it is beyond the part
bool sim_cut_place_scallop(sim_cut_t *cut, common_error_t *e);

/// Derive slices and speed of the present pass.
void sim_cut_plan_pass(sim_cut_t *cut);

/// @return whether another pass follows the finished one
bool sim_cut_has_next_pass(const sim_cut_t *cut);

/// Store the results of the finished pass and prepare the next one, once the controller has
/// selected it. Until then nothing changes.
void sim_cut_next_pass(sim_cut_t *cut);

/// @return results of the present or last pass
sim_pass_result_t sim_cut_pass_result(const sim_cut_t *cut);

/// @return [s] planned machine time of all passes, engaging and disengaging included
double sim_cut_planned_s(const sim_cut_t *cut);

/// @return [turn] planned length of the state cutting in all passes
double sim_cut_planned_in_all(const sim_cut_t *cut);

/// @return whether no pass before the last one cut deeper than the drawing allows
bool sim_cut_left_stock(const sim_cut_t *cut);

#endif
