// SPDX-License-Identifier: Apache-2.0
/// cam_command: how far and how fast U is commanded, feed-forward included.
///
/// At the speed omega the command is u + k1 u' omega + k2 u'' omega^2 (cam_axis_command.h), so it
/// may leave a stroke that contains u, and move faster than u. Context: slow side.
/// Source: MATHS.md (213), (215), (216).
#ifndef CAM_COMMAND_H
#define CAM_COMMAND_H

#include "cam_cut.h" // cam_cut_t, cam_demand_t

/// Bound the command by the peaks of the table. If this bound leaves the stroke, at a speed that
/// the spindle reaches, read all knots: u and u' seldom peak at the same angle.
/// @return [nm] the largest distance of U's command from the middle of its stroke. This demand and
///         the next two are 0 without gains.
cam_demand_t cam_command_stroke_demand(const cam_cut_t *c);

/// @return [um/s] the sum of the peaks of u' omega, k1 u'' omega^2 and k2 u''' omega^3 (0 for a
///         table with a speed channel). The limit follows from the limits and gains of U.
cam_demand_t cam_command_speed_demand(const cam_cut_t *c);

/// @return [mm/s2] the sum of the peaks of u'' omega^2 and k1 u''' omega^3, likewise
cam_demand_t cam_command_acceleration_demand(const cam_cut_t *c);

#endif
