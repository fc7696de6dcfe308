// SPDX-License-Identifier: Apache-2.0
/// sim_design_table: the surface of a table in double: the firmware's quintics without fixed-point
/// rounding.
#ifndef SIM_DESIGN_TABLE_H
#define SIM_DESIGN_TABLE_H

#include "cam_table.h" // cam_table_t

/// @param turn  [turn] drawing's angle, any
/// @param z_mm  any; clamped to the channels
/// @return      [mm] x - u. Source: TABLE_FORMAT.md, "Knots".
double sim_design_table_radius_mm(const cam_table_t *t, double turn, double z_mm);

/// @param turn  [turn] drawing's angle, any
/// @return      spindle speed over its mean; 1 without a speed channel
double sim_design_table_ratio(const cam_table_t *t, double turn, double z_mm);

/// @return [mm] the long half axis x
double sim_design_table_long_mm(const cam_table_t *t, double z_mm);

#endif
