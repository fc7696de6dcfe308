// SPDX-License-Identifier: Apache-2.0
/// cam_progress: how many turns of the pass are left, as the course of its feed is laid.
///
/// A pass is its rehearsal, if there is one, and the cut with engaging and disengaging; what the
/// axes take to approach the start is not in it. The override of the feed is in it as it is laid,
/// and a hold as if it were resumed at once. Context: slow side.
#ifndef CAM_PROGRESS_H
#define CAM_PROGRESS_H

#include "cam_machine.h" // cam_machine_t
#include <stdbool.h>     // bool
#include <stdint.h>      // int64_t, uint32_t

typedef struct {
    bool has_end;      ///< false: only a stop ends it, or there is no table
    int64_t left_q32;  ///< [turn] to the end of the pass; out of the work: of the next one
    int64_t whole_q32; ///< [turn] that are over in this pass, and those that are left
    uint32_t mrpm;     ///< [r/min / 1000] mean set-point of the spindle, its override included
} cam_progress_t;

/// @return where the pass stands in the newest tick
cam_progress_t cam_progress(const cam_machine_t *m);

#endif
