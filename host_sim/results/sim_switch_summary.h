// SPDX-License-Identifier: Apache-2.0
/// sim_switch_summary: action of the position switches, as JSON; nothing when none is in use.
///
///     "switches": [{"output", "windows_per_turn", "on_deg", "off_deg", "dead_time_us",
///                   "times_on", "times_off", "other_on", "other_off",
///                   "on_error_deg": {"mean", "max"}, "off_error_deg": .., "z_mm": [low, high]}]
///
/// sim_switches.h defines the errors; without any change an error is null.
#ifndef SIM_SWITCH_SUMMARY_H
#define SIM_SWITCH_SUMMARY_H

#include "sim_switches.h" // sim_switches_t
#include <cjson/cJSON.h>

void sim_switch_summary(cJSON *root, const sim_switches_t *switches);

#endif
