// SPDX-License-Identifier: Apache-2.0
/// cam_progress: completed and remaining turns of the pass.
///
/// A pass is the rehearsal, if any, and the cut with engaging and disengaging, without the approach
/// to the start. The feed override is included as planned; a hold counts as if resumed at once.
/// Context: slow side.
#ifndef CAM_PROGRESS_H
#define CAM_PROGRESS_H

#include "cam_machine.h" // cam_machine_t
#include <stdbool.h>     // bool
#include <stdint.h>      // int64_t, uint32_t

typedef struct {
    bool has_end;      ///< false: only stop ends the pass, or no table is selected
    int64_t left_q32;  ///< [turn] to the end of the pass, or length of the next one
    int64_t whole_q32; ///< [turn] completed and remaining
    uint32_t mrpm;     ///< [r/min / 1000] mean spindle set-point with its override
} cam_progress_t;

/// @return progress in the newest tick
cam_progress_t cam_progress(const cam_machine_t *m);

#endif
