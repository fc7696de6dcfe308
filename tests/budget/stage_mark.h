// SPDX-License-Identifier: Apache-2.0
/// stage_mark: reads the counter where a stage of the tick ends.
///
/// firmware/tick/cam_tick.c is compiled once more with this header in front, which wraps the calls
/// of its stages; the rest of the firmware is as it is. A mark is a call of a function outside the
/// link-time optimisation: the stores of a stage are done before it, and every mark costs the same.
/// stages.h counts with it.
#ifndef STAGE_MARK_H
#define STAGE_MARK_H

#include "cam_tick_inner.h" // the stages, declared before they are wrapped
#include "hal/hal.h"        // hal_outputs_write_isr, hal_spindle_write_isr

/// A stage is what lies between its mark and the one before.
typedef enum {
    stage_begin,   ///< of the interrupt
    stage_sense,   ///< configuration and record taken, all reads
    stage_angle,   ///< counts and index -> angle and speed
    stage_play,    ///< sequence, set-points
    stage_command, ///< set-points as the drives want them
    stage_guard,   ///< limits, faults, retract
    stage_actuate, ///< all writes
    stage_plan,    ///< every n-th tick: what changes slowly
    stage_publish, ///< learning, trace and status, the interrupt's end
    stage_n_marks
} stage_t;

/// Read the counter. @param stage  that ends here
void stage_mark(stage_t stage);

#ifdef STAGE_MARKED // cam_tick.c alone
#define cam_spindle_step_isr(...)                                                                  \
    (stage_mark(stage_sense), cam_spindle_step_isr(__VA_ARGS__), stage_mark(stage_angle))
#define cam_play_step_isr(...) (cam_play_step_isr(__VA_ARGS__), stage_mark(stage_play))
#define cam_guard_step_isr(...) (stage_mark(stage_command), cam_guard_step_isr(__VA_ARGS__))
#define hal_outputs_write_isr(...) (stage_mark(stage_guard), hal_outputs_write_isr(__VA_ARGS__))
#define hal_spindle_write_isr(...) (hal_spindle_write_isr(__VA_ARGS__), stage_mark(stage_actuate))
#define cam_turn_bins_add_isr(...) (stage_mark(stage_plan), cam_turn_bins_add_isr(__VA_ARGS__))
#endif

#endif
