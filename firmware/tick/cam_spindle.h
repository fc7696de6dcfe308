// SPDX-License-Identifier: Apache-2.0
/// cam_spindle: from encoder counts and index to master position and speed.
///
/// Converts counts to a binary angle exactly (any counts per turn, no drift), adds half a count to
/// centre the quantisation, and smooths the steps with a second-order tracking observer, which also
/// gives the speed. Speed and position are positive in the direction of cutting.
///
/// A tick off its time by more than a sixteenth of a period is evaluated at its time stamp, so a
/// late tick causes no angle error.
///
/// An encoder that stands still, or only dithers, while the spindle turns shows in has_stopped: in
/// this tick the spindle, at the speed of its last advance, would have gone on by more than
/// `still_q32` since then.
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

/// State; zero-initialised: not started.
typedef struct {
    bool is_started;
    bool is_synced;
    uint32_t clock;        ///< time stamp of the last tick
    uint32_t counts;       ///< [counts] of the last tick, in the direction of cutting
    uint32_t n_index;      ///< of the last tick
    uint32_t index_counts; ///< [counts] of the last edge, or where the angle was forgotten
    int32_t index_error;   ///< [counts] sum of deviations since the first edge
    int32_t in_turn;       ///< [counts] 0 .. counts_per_turn - 1 since the index
    bool is_off_time;      ///< the last tick was visibly off its time
    uint32_t max_period;   ///< [1 / clock_hz] longest period
    uint32_t n_late;       ///< ticks beyond late_clocks
    int32_t behind;        ///< [counts] behind the farthest position, at most 0
    int32_t going_q32;     ///< [turn / 2^32 per tick] speed when the encoder last advanced
    int32_t still_q32;     ///< [turn / 2^32] travel at that speed since then
    int64_t pos_q32;       ///< [turn, Q32.32] observer
    int64_t speed_q64;     ///< [turn / 2^64 per tick] observer
} cam_spindle_t;

/// Take the reading of a tick, in constant time.
/// @param cfg        forget the angle after changing it
/// @param alpha_q40  [turn / 2^40 per tick^2] commanded acceleration of the spindle since the last
///                   tick, 0 at uniform speed; it causes no lag
void cam_spindle_step_isr(cam_spindle_t *s, const cam_spindle_config_t *cfg, const cam_sense_t *in,
                          int32_t alpha_q40, cam_angle_t *angle);

/// Check the index, once per plan: the first edge makes the angle known, later ones reveal lost
/// counts, and an edge may be overdue.
/// @return fault lost_counts, index_missing or none
uint32_t cam_spindle_check_index_isr(cam_spindle_t *s, const cam_spindle_config_t *cfg,
                                     const hal_encoder_t *encoder);

/// Forget the index and all edges up to now; counts, observer and speed continue.
void cam_spindle_forget_isr(cam_spindle_t *s, const hal_encoder_t *encoder);

#endif
