// SPDX-License-Identifier: Apache-2.0
/// sim_summary: the common part of all cuts' summaries, as JSON.
///
/// The same input and seed give the same bytes, except for wall_time_s and ticks_per_s.
#ifndef SIM_SUMMARY_H
#define SIM_SUMMARY_H

#include "sim_cut.h" // sim_cut_t, sim_session_t
#include <cjson/cJSON.h>
#include <stdint.h> // uint32_t

void sim_summary_number(cJSON *object, const char *key, double value);

void sim_summary_text(cJSON *object, const char *key, const char *text);

/// Add a number, or null if nothing was gauged.
void sim_summary_sampled(cJSON *object, const sim_session_t *s, const char *key, double value);

/// Add a list of the names of faults. @param faults  a bit for each of CAM_FAULTS
void sim_summary_faults(cJSON *root, const char *key, uint32_t faults);

/// Add "form_error_um" against the drawing, "control_error_um" against the played surface (the same
/// without a target), and "following_error_um".
void sim_summary_errors(cJSON *root, const sim_session_t *s);

/// Add the progress of the cut and the removed metal to "cut".
void sim_summary_progress(cJSON *cut, const sim_session_t *s);

/// Add "cam": lobes, surface speed, effective rake. Adds nothing for a skirt, nor for lobes without
/// a report, where the gauge compares X - U with the table.
void sim_summary_lobes(cJSON *root, const sim_session_t *s);

/// @return [%] largest deviation of the surface speed from the plan of table and profile
double sim_summary_off_plan_percent(const sim_session_t *s);

/// Add the controller's learning and the convergence of the error:
///     "error_per_turn_um": [..]            per turn: rehearsal, then cut (sim_work.h)
///     "error_per_turn": {"turn", "state"}  start of each; "rehearsing" or "cutting"
///     "learning": is_on, phase, reason, turns, masked, k1_ns, k2_us2, harmonics, ...
void sim_summary_learning(cJSON *root, sim_cut_t *cut);

/// Print a summary and delete it. @return to be freed; NULL when memory is short
char *sim_summary_print(cJSON *root);

#endif
