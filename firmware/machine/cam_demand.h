// SPDX-License-Identifier: Apache-2.0
/// cam_demand: what a cut demands of every axis, against what the machine can.
///
/// Limits are the smaller of the machine's parameters and those that the table was made for. The
/// table guarantees peaks of u, u' and u''; at omega U needs u' omega and u'' omega^2. Along the
/// feed U and the swing change with the slices of the table, at a speed that jumps where one slice
/// ends: a set-point takes the jump, and what that needs comes on top. Of a Z that others lead the
/// feed is what table or parameters tell. Context: slow side.
#ifndef CAM_DEMAND_H
#define CAM_DEMAND_H

#include "cam_err.h"   // cam_err_t
#include "cam_param.h" // cam_params_t
#include "cam_table.h" // cam_table_t
#include <stdint.h>    // uint32_t, int64_t, uint64_t

/// A cut at a mean speed of the spindle.
typedef struct {
    const cam_table_t *t;
    const cam_params_t *p;
    uint32_t tick_hz;   ///< [Hz]
    uint32_t mean_mrpm; ///< [r/min / 1000] below 2^26
    uint32_t peak_mrpm; ///< [r/min / 1000] highest within a turn, up to four times that
    uint64_t feed_nm;   ///< [nm] per turn, below 2^24
} cam_cut_t;

/// Both sides of a limit.
typedef struct {
    cam_err_t err;   ///< what it means to exceed it
    int64_t limit;   ///< as cam_feasibility_t has it
    uint64_t needed; ///< in the same unit, rounded up; it never falls with speed or feed
} cam_demand_t;

/// @return the first limit that a cut exceeds, cam_ok with none. Source: MATHS.md (61) .. (64),
/// (42), (44).
cam_demand_t cam_demand_first_exceeded(const cam_cut_t *c);

#endif
