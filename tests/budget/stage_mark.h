// SPDX-License-Identifier: Apache-2.0
/// stage_mark: the counter is read where a stage of the tick ends.
///
/// firmware/tick/cam_tick.c is compiled once more with this header in front; the rest of the
/// firmware is as it is. A mark is a call of a function outside the link-time optimisation: stores
/// of a stage are done before it, and every mark costs the same. stages.h counts with it.
#ifndef STAGE_MARK_H
#define STAGE_MARK_H

/// A stage is what lies between its mark and the one before.
typedef enum {
    stage_begin,   ///< of the interrupt
    stage_sense,   ///< configuration and record taken, all reads
    stage_angle,   ///< counts and index -> angle and speed
    stage_play,    ///< sequence, set-points
    stage_guard,   ///< limits, faults, what a fault leaves of the set-points
    stage_actuate, ///< set-points as the drives want them, all writes
    stage_plan,    ///< every n-th tick: what changes slowly
    stage_publish, ///< status and trace, the interrupt's end
    stage_n_marks
} stage_t;

/// Read the counter. @param stage  that ends here
void stage_mark(stage_t stage);

#define CAM_TICK_MARK(stage) stage_mark(stage_##stage)

#endif
