// SPDX-License-Identifier: Apache-2.0
/// sim_summary: the common part of all cuts' summaries, as JSON.
///
/// The same input and seed give the same bytes, except for wall_time_s and ticks_per_s.
#ifndef SIM_SUMMARY_H
#define SIM_SUMMARY_H

#include "sim_out.h"     // sim_out_t
#include "sim_session.h" // sim_session_t
#include <cjson/cJSON.h>
#include <stdbool.h> // bool
#include <stdint.h>  // uint32_t

void sim_summary_number(cJSON *object, const char *key, double value);

void sim_summary_text(cJSON *object, const char *key, const char *text);

/// Add a number, or null if nothing was gauged.
void sim_summary_sampled(cJSON *object, const sim_session_t *s, const char *key, double value);

/// Add a list of the names of faults. @param faults  a bit for each of CAM_FAULTS
void sim_summary_faults(cJSON *root, const char *key, uint32_t faults);

/// Add "form_error_um" against the drawing, "control_error_um" against the played surface (the same
/// without a target), and "following_error_um".
void sim_summary_errors(cJSON *root, const sim_session_t *s);

/// Add the progress of the cut to "cut".
void sim_summary_progress(cJSON *cut, const sim_session_t *s);

/// Add the removed metal to "cut".
void sim_summary_metal(cJSON *cut, const sim_session_t *s);

/// Write a summary and free it. @return false when memory is short
bool sim_summary_write(sim_out_t *o, cJSON *root);

#endif
