// SPDX-License-Identifier: Apache-2.0
/// sim_lobe_summary: the lobes in a summary.
#ifndef SIM_LOBE_SUMMARY_H
#define SIM_LOBE_SUMMARY_H

#include "sim_session.h" // sim_session_t
#include <cjson/cJSON.h>

/// Add "cam": lobes, surface speed, effective rake. Adds nothing for a skirt, nor for lobes without
/// a report, where the gauge compares X - U with the table.
void sim_lobe_summary(cJSON *root, const sim_session_t *s);

/// @return [%] largest deviation of the surface speed from the plan of table and profile
double sim_lobe_off_plan_percent(const sim_session_t *s);

#endif
