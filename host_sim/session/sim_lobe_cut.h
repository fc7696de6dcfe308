// SPDX-License-Identifier: Apache-2.0
/// sim_lobe_cut: the differences between the cut of lobes and that of a skirt.
///
/// Instead of the tool tip of sim_session the wheel, or the tip of the swung tool, of sim_lobe_work
/// cuts. In sim_session_t then part_turn is the polar angle of the contact, exact_mm the radius of
/// the profile there, and radius_mm that plus the distance of the circle from it along the normal.
#ifndef SIM_LOBE_CUT_H
#define SIM_LOBE_CUT_H

#include "sim_session.h" // sim_session_t

/// @param tip_mm  radius of the tool's tip that the user gave, 0: none
/// @param name    of the table file, for messages
/// @return        false and *e when design or tip do not fit the table
bool sim_lobe_cut_check(const sim_session_t *s, double tip_mm, const char *name, common_error_t *e);

/// Before the first sample of a part with lobes.
/// @param tip_mm  radius of the tool's tip, 0: 0.4 mm; at most the roller's counts
void sim_lobe_cut_begin(sim_session_t *s, double tip_mm);

/// For every sample of a part with lobes, instead of the gauge of a skirt.
/// @param turn  [turn] drawing's angle, phase taken off, not wrapped
void sim_lobe_cut_gauge(sim_session_t *s, double turn);

/// @return [mm/s] surface speed that is due on the base circle
double sim_lobe_cut_due_mm_s(const sim_session_t *s);

#endif
