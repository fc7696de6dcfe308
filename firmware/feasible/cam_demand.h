// SPDX-License-Identifier: Apache-2.0
/// cam_demand: what a cut demands of every axis, compared with what the machine can do.
///
/// A limit is the smaller of the machine's parameter and the limit for which the table was made.
/// The table guarantees peaks of u, u' and u''; at a spindle speed omega, U needs the speed
/// u' omega and the acceleration u'' omega^2. cam_z_coupling.h adds the effect of the feed,
/// cam_command.h that of the feed-forward. If another controller moves Z, its feed is taken to
/// be feed_nm or, if that is 0, the table's. Context: slow side.
#ifndef CAM_DEMAND_H
#define CAM_DEMAND_H

#include "cam_cut.h"   // cam_cut_t
#include "cam_err.h"   // cam_err_t
#include "cam_param.h" // cam_params_t
#include "cam_table.h" // cam_table_t
#include <stdint.h>    // int64_t, uint64_t

enum { cam_n_demands = 26 };

/// Every limit of the axes, in the order in which excesses are reported.
typedef struct {
    cam_demand_t of[cam_n_demands];
} cam_demands_t;

/// @param t  NULL: without a table
/// @return   [nm] travel of U to either side of the middle of its stroke
int32_t cam_demand_half_stroke_nm(const cam_table_t *t, const cam_params_t *p);

/// X must be clear of all stock on the part and of the surface above u = 0 (cam_table_rise_nm).
/// @param t  NULL: without a table
/// @return   [nm] distance from which X engages, and by which it leaves
int32_t cam_demand_clearance_nm(const cam_table_t *t, const cam_params_t *p);

/// Compute what a cut demands of every axis.
/// Source: MATHS.md (61) .. (64), (42), (44).
cam_demands_t cam_demand_all(const cam_cut_t *c);

/// @return the first limit that the cut exceeds; err = cam_ok when it exceeds none
cam_demand_t cam_demand_first_exceeded(const cam_cut_t *c);

#endif
