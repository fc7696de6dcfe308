// SPDX-License-Identifier: Apache-2.0
/// cam_derived_limits: limits derived from machine and part where none was set, the largest values
/// that the tick rate allows, and the form error due to the resolution of the port's outputs.
///
/// No default fits every machine: the jump window scales with the encoder, the following error with
/// the part. 0 selects the derived value. Context: slow side, integers only.
#ifndef CAM_DERIVED_LIMITS_H
#define CAM_DERIVED_LIMITS_H

#include "cam_err.h"     // CAM_MUST_USE
#include "cam_param.h"   // cam_params_t, cam_param_id_t
#include "cam_refusal.h" // cam_refusal_t
#include "cam_table.h"   // cam_table_t
#include <stdint.h>      // int32_t, uint32_t

/// [Hz] At this tick rate or above, measurements of U are recent enough for a limit derived from
/// the part. Slower ticks belong to field buses, whose measurements are some ticks old.
enum { cam_derived_limits_least_hz = 5000 };

/// Outside the cut every axis uses a quarter of its speed and of its acceleration.
enum { cam_derived_limits_approach_share = 4 };

/// Largest accepted difference between the counts of a tick and the observer's prediction: twice
/// what full acceleration of the spindle and a speed ripple of 1 % of its highest speed cause, plus
/// 4 counts of quantisation, at least 8; plus index_tolerance_counts for the encoder's jitter.
/// @return [counts] jump_window_counts, or if that is 0 the derived one, at most 2^30; cam_build.c
///         limits both to a quarter turn
/// Source: MATHS.md (166).
int32_t cam_derived_limits_jump_counts(const cam_params_t *params, uint32_t tick_hz);

/// The accepted following error of U in the cut: a fifth of its travel in the table at the present
/// amplitude, which of an oval is a tenth of the ovality; at least 0.01 mm, at most 0.2 mm. Without
/// k1 the lag of the drive is unknown, and 0.1 mm is the least.
/// @param table  NULL: none is selected, and U does not cut
/// @return [nm] following_limit_nm, or where that is 0 the derived one
int32_t cam_derived_limits_following_nm(const cam_params_t *params, const cam_table_t *table);

/// The accepted following error of U out of the cut: the lag of its drive, since motions by time
/// have no feed-forward, plus that of the cut, but not less than half of that lag, half of the lead
/// and the travel of half a tick, all at the speed of the approach or of a faster jog.
/// @return [nm] at least that of the cut; following_limit_nm replaces the part beyond the lag
/// Source: MATHS.md (167).
int32_t cam_derived_limits_approach_nm(const cam_params_t *params, const cam_table_t *table,
                                       uint32_t tick_hz);

/// @return [mHz] default bandwidth of the observer: the requested one, at most a twentieth of the
///         tick rate, where one tick corrects two thirds of an angle error
int32_t cam_derived_limits_usual_mHz(int32_t wanted_mHz, uint32_t tick_hz);

/// @return the largest value of a parameter that fits the tick rate, and for the speeds of X and Z
///         also the port's outputs; of other parameters the end of their range
int32_t cam_derived_limits_most(cam_param_id_t id, uint32_t tick_hz);

/// Check what the interrupt relies on: the history reaches back over the lead and the latency of
/// U's scale, the observer is slower than the tick, feed-forward gains fit 15 integer bits.
/// The outputs of X and Z can transmit their speeds. The feed-forward keeps the command of U within
/// its limits, and every jerk limit has a filter window (cam_gains.h).
/// @return cam_ok, cam_err_param_tick (for lead_ns also their sum), cam_err_param_output,
///         cam_err_jerk or cam_err_gain
CAM_MUST_USE cam_refusal_t cam_derived_limits_check(const cam_params_t *params, uint32_t tick_hz);

/// Bound the form error that the steps of the set-points cause: half a step of U, half a step of X,
/// and half a step of Z times the steepest slope of the part over its height.
/// @param table  in use; NULL: none, and the slope counts as 0
/// @return       [pm] rounded down, saturated; 0 when the port states no step at all
/// Source: MATHS.md (183).
uint32_t cam_derived_limits_form_pm(const cam_table_t *table);

/// @param counts_per_turn  of the spindle's encoder, positive
/// @return [pm] largest motion of U per count of the encoder at uniform speed, rounded down,
///         saturated. Half of it bounds the form error of the counts where edges have no time
///         stamp.
/// Source: MATHS.md (185).
uint32_t cam_derived_limits_count_pm(const cam_table_t *table, int32_t counts_per_turn);

/// Whole encoder counts per tick: all ticks of a turn see the same part of a count, so that the
/// counts do not average. Concerns ports without time stamps of the edges.
/// @param mrpm  [r/min / 1000] speed of the spindle
/// @return [r/min / 1000] the next lower speed, in whole r/min, at which they average; 0: they do
///         at this one, or at none
/// Source: MATHS.md (231).
uint32_t cam_derived_limits_averaging_mrpm(const cam_params_t *params, uint32_t mrpm,
                                           uint32_t tick_hz);

#endif
