// SPDX-License-Identifier: Apache-2.0
/// cam_steady: waiting for a steady spindle before a cut or its rehearsal.
///
/// Turns are timed from the approach on. The cut begins when the axes are at their start and enough
/// successive turns agree in their mean speed, MATHS.md (230). A spindle that was steady all along
/// delays the start by two turns at most, less the time of the approach.
/// Context: ISR, once per plan; constant time.
#ifndef CAM_STEADY_H
#define CAM_STEADY_H

#include "cam_config.h" // cam_play_config_t
#include "cam_state.h"  // cam_state_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int64_t, uint32_t

/// State; zero-initialised: no turn has begun.
typedef struct {
    int64_t from_q32;      ///< [turn] master position where the present turn began
    uint32_t ticks;        ///< [ticks] since then; 0: none has begun
    uint32_t last_q24;     ///< [turn / 2^24] length of the last turn: up to a plan more than one
    uint32_t last_ticks;   ///< [ticks] its duration
    uint32_t n_turns;      ///< turns since the approach began
    uint32_t n_agreeing;   ///< successive turns that agreed with the one before
    uint32_t waited_ticks; ///< [ticks] for which the axes have been at their start
} cam_steady_t;

/// @param state     outside of the approach (engaging, rehearsing) everything is forgotten
/// @param pos_q32   [turn] master position
/// @param is_there  the axes are at their start
/// @return whether the cut or its rehearsal may begin; then everything is forgotten, too
bool cam_steady_isr(cam_steady_t *s, const cam_play_config_t *cfg, cam_state_t state,
                    int64_t pos_q32, bool is_there);

#endif
