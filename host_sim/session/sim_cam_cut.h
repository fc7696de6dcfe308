// SPDX-License-Identifier: Apache-2.0
/// sim_cam_cut: what is different in the cut of a cam.
///
/// The tool tip of sim_cut becomes the wheel, or the tip of the swung tool, of sim_cam_work. In
/// sim_cut_t then part_turn is the polar angle of the contact, exact_mm the radius of the profile
/// there, and radius_mm that plus the distance of the circle from it along the normal.
#ifndef SIM_CAM_CUT_H
#define SIM_CAM_CUT_H

#include "sim_cut.h" // sim_cut_t

/// What a user can do about a table without its report.
#define SIM_CAM_REMEDY "make the table again with tools/mktables, or give --design"

/// [mm] radius of the tool's tip, when none is given: at most the roller's.
#define SIM_CAM_TIP_MM 0.4

/// @param name  of the table file, for messages
/// @return      false and *e when design or options do not fit the table
bool sim_cam_cut_check(const sim_cut_t *cut, const char *name, sim_error_t *e);

/// Before the first tick of a cam.
void sim_cam_cut_begin(sim_cut_t *cut);

/// In every tick of a cam, instead of the gauge of a skirt.
/// @param turn  [turn] spindle in the sense of cutting, phase taken off, not wrapped
void sim_cam_cut_gauge(sim_cut_t *cut, double turn);

/// @return [rad/s] mean speed of the spindle
double sim_cam_cut_mean_rad_s(const sim_cut_t *cut);

/// @return [mm/s] surface speed that is due on the base circle
double sim_cam_cut_due_mm_s(const sim_cut_t *cut);

#endif
