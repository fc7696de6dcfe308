// SPDX-License-Identifier: Apache-2.0
/// sim_lobe_cut: the differences between cutting lobes and a skirt.
///
/// The wheel or the swung tool's tip of sim_lobe_work cuts instead of the tool tip of sim_session.
/// Then part_turn in sim_session_t is the polar angle of the contact, exact_mm the radius of the
/// profile there, and radius_mm adds the distance of the circle along the normal.
#ifndef SIM_LOBE_CUT_H
#define SIM_LOBE_CUT_H

#include "sim_session.h" // sim_session_t

/// @param tip_mm  radius of the tool's tip given by the user, 0: none
/// @param name    name of the table file, for messages
/// @return        false and *e when design or tip do not fit the table
bool sim_lobe_cut_check(const sim_session_t *s, double tip_mm, const char *name, common_error_t *e);

/// Prepare for the first sample of a part with lobes.
/// @param tip_mm  radius of the tool's tip, 0: 0.4 mm; limited to the roller's
void sim_lobe_cut_begin(sim_session_t *s, double tip_mm);

/// Gauge a sample of a part with lobes.
/// @param turn  [turn] drawing's angle less the phase, not wrapped
void sim_lobe_cut_gauge(sim_session_t *s, double turn);

/// @return [mm/s] nominal surface speed on the base circle
double sim_lobe_cut_due_mm_s(const sim_session_t *s);

#endif
