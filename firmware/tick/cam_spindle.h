// SPDX-License-Identifier: Apache-2.0
/// cam_spindle: from encoder counts and index to master position and speed.
///
/// Counts are carried to a binary angle exactly (any counts per turn, no drift), half a count is
/// added to centre the quantisation, and a second-order tracking observer turns the stairs into
/// angle and speed between counts. Speed and position are positive in the sense of cutting.
///
/// A tick that comes off its time by more than a sixteenth of a period is taken at its time stamp,
/// so a late tick costs no angle.
///
/// Errors of the observer, MATHS.md (52), (53), with bandwidth f_o (poles near w_o = 2 pi f_o):
///   constant speed           mean 0; quantisation ripple below half a count
///   constant acceleration    angle lags by (1 - 2 w_o T) acceleration / w_o^2, T one tick,
///                            for the part of it that was not commanded
///   speed ripple at f        (1 - 2 w_o T) f^2 / (f^2 + f_o^2) of the angle ripple is missed
/// Context: ISR unless noted.
#ifndef CAM_SPINDLE_H
#define CAM_SPINDLE_H

#include "cam_config.h" // cam_spindle_config_t
#include "cam_record.h" // cam_sense_t, cam_angle_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t, int64_t

/// State. Zero-initialised is: not started.
typedef struct {
    bool is_started;
    bool is_synced;
    uint32_t clock;        ///< time stamp of the last tick
    uint32_t counts;       ///< [counts] of the last tick, in the sense of cutting
    uint32_t n_index;      ///< of the last tick
    uint32_t index_counts; ///< [counts] of the last edge, before it where the angle was forgotten
    int32_t index_error;   ///< [counts] sum of deviations since the first edge
    int32_t in_turn;       ///< [counts] 0 .. counts_per_turn - 1 since the index
    bool is_off_time;      ///< the last tick came visibly off its time
    uint32_t max_period;   ///< [1 / clock_hz] longest distance of two ticks
    uint32_t n_late;       ///< ticks beyond late_clocks
    int64_t pos_q32;       ///< [turn, Q32.32] observer
    int64_t speed_q64;     ///< [turn / 2^64 per tick] observer
} cam_spindle_t;

/// Take one reading.
/// @param s    state
/// @param cfg  configuration; after a change of it the angle must be forgotten
/// @param in   inputs of the tick
/// @param alpha_q40  [turn / 2^40 per tick^2] acceleration that the spindle was commanded since the
///             last tick, 0 at uniform speed: known, it causes no lag
/// @param angle      result
/// Constant time.
void cam_spindle_step_isr(cam_spindle_t *s, const cam_spindle_config_t *cfg, const cam_sense_t *in,
                          int32_t alpha_q40, cam_angle_t *angle);

/// Check the index: the first edge makes the angle known, a later one shows lost counts, and an
/// edge may be overdue. Called once per plan, so that an edge is at most one plan old.
/// @return fault lost_counts, index_missing or none
uint32_t cam_spindle_check_index_isr(cam_spindle_t *s, const cam_spindle_config_t *cfg,
                                     const hal_encoder_t *encoder);

/// Forget the index, and edges up to now; counts, angle observer and speed go on.
void cam_spindle_forget_isr(cam_spindle_t *s, const hal_encoder_t *encoder);

#endif
