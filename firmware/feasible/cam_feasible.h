// SPDX-License-Identifier: Apache-2.0
/// cam_feasible: whether this machine can turn this table at this speed, and if not, why.
///
/// Speeds are mean speeds. Where the table modulates the spindle, its highest speed within a turn
/// is larger by the largest ratio, and the peaks that the table guarantees contain the modulation.
///
/// Read the judgement of a cut first. The parts after it check and derive parameters where no speed
/// is known yet: limits that were not set, windows and gains of U's motion, its position loop, and
/// what the operator changes in a cut; last the arithmetic of limits. Context of all functions:
/// slow side. Source: MATHS.md (61).
#ifndef CAM_FEASIBLE_H
#define CAM_FEASIBLE_H

#include "cam_config.h" // cam_play_config_t
#include "cam_err.h"    // cam_err_t
#include "cam_param.h"  // cam_params_t, cam_param_id_t, cam_refusal_t
#include "cam_servo.h"  // cam_servo_config_t
#include "cam_table.h"  // cam_table_t
#include "hal/hal.h"    // hal_axis_t
#include <stdint.h>     // int32_t, int64_t, uint32_t, uint64_t

/// One limit and what the cut needs of it. A limit is the smaller of the machine's parameter and
/// the limit for which the table was made. The table guarantees peaks of u, u' and u''; at a
/// spindle speed omega, U needs the speed u' omega and the acceleration u'' omega^2. The feed and
/// the feed-forward add to that. If another controller moves Z, its feed is taken to be feed_nm or,
/// if that is 0, the table's.
typedef struct {
    cam_err_t err;   ///< error that reports an excess
    int64_t limit;   ///< in the unit of CAM_ERR_LIMITS for err
    uint64_t needed; ///< in the same unit, rounded up; it never decreases as speed or feed rises
} cam_demand_t;

enum { cam_n_demands = 26 };

/// In the order in which excesses are reported.
typedef struct {
    cam_demand_t of[cam_n_demands];
} cam_demands_t;

/// Judge a speed, the verdict alone: one comparison with each limit.
/// @param speed_mrpm  [r/min / 1000] > 0
/// @param tick_hz     [Hz] rate of the tick
/// @return            cam_ok, or the error of the first limit that is exceeded
CAM_MUST_USE cam_err_t cam_feasible_check(const cam_table_t *table, const cam_params_t *params,
                                          uint32_t speed_mrpm, uint32_t tick_hz);

/// @param axes  result: every limit of the axes with what the cut needs of it
/// @return      the turns of feed, the only demand that falls with a rising feed
cam_demand_t cam_feasible_demands(const cam_table_t *table, const cam_params_t *params,
                                  uint32_t speed_mrpm, uint32_t tick_hz, cam_demands_t *axes);

/// @return [r/min / 1000] highest mean speed at which all limits hold, by 26 judgements; 0: none
uint32_t cam_feasible_highest_mrpm(const cam_table_t *table, const cam_params_t *params,
                                   uint32_t tick_hz);

/// @return [nm] largest feed per turn with which all limits hold, by 24 judgements; 0: none
uint32_t cam_feasible_largest_feed_nm(const cam_table_t *table, const cam_params_t *params,
                                      uint32_t speed_mrpm, uint32_t tick_hz);

/// @return for a message: the first limit that is exceeded, if any, and what would be feasible;
///         `needed` is rounded up
cam_refusal_t cam_feasible(const cam_table_t *table, const cam_params_t *params,
                           uint32_t speed_mrpm, uint32_t tick_hz);

/// @return [r/min / 1000] highest speed within a turn of this mean speed, rounded up, saturated.
/// Example: a ratio of up to 1.25 makes 1250 r/min of a mean speed of 1000 r/min.
uint32_t cam_feasible_peak_mrpm(const cam_table_t *table, uint32_t mean_mrpm);

/// @param t  NULL: without a table
/// @return   [nm] travel of U to either side of the middle of its stroke
int32_t cam_demand_half_stroke_nm(const cam_table_t *t, const cam_params_t *p);

/// X must be clear of all stock on the part and of the surface above u = 0 (cam_table_rise_nm).
/// @param t  NULL: without a table
/// @return   [nm] distance from which X engages, and by which it leaves
int32_t cam_demand_clearance_nm(const cam_table_t *t, const cam_params_t *p);

/// Derived limits: limits derived from machine and part where none was set, the largest values that
/// the tick rate allows, and the form error due to the resolution of the port's outputs. No default
/// fits every machine: the jump window scales with the encoder, the following error with the part.
/// 0 selects the derived value.

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
/// k1 the lag of a drive that takes positions is unknown, and 0.1 mm is the least.
/// @param table  NULL: none is selected, and U does not cut
/// @return [nm] following_limit_nm, or where that is 0 the derived one
int32_t cam_derived_limits_following_nm(const cam_params_t *params, const cam_table_t *table);

/// The accepted following error of U out of the cut: the lag of its drive, since motions by time
/// have no feed-forward, plus that of the cut, but not less than half of that lag, half of the lead
/// and the travel of half a tick, all at the speed of the approach or of a faster jog. A U that
/// takes forces, whose loop may be weak, is accepted 0.1 mm at least.
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
/// its limits, and every jerk limit has a filter window (cam_gains_check()).
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

/// Gains: windows of timed moves, and limits of U's feed-forward gains. A motion by time is the
/// mean over a window (cam_motion.h), whose length follows from the jerk of the axis, or where none
/// is set from tick, limits and feed-forward. In the cut the feed-forward adds k1 times the speed
/// and k2 times the acceleration to the command of U, and so the command itself moves with v + k1 a
/// + k2 j. Gains that would add more than about U's highest speed are refused. Source: MATHS.md
/// (212), (213).

/// @return log2 of an axis's window in ticks (U) or plans (X, Z), 0 .. cam_jerk_filter_most_log2
uint32_t cam_gains_log2_window(const cam_params_t *params, hal_axis_t axis, uint32_t tick_hz);

/// Find the largest k1_ns or k2_us2, or the least jerk above 0, that fits the other parameters.
/// @param id  cam_param_k1_ns, .._k2_us2, .._u_jerk_m_per_s3, x_.. or z_..
int64_t cam_gains_bound(const cam_params_t *params, cam_param_id_t id, uint32_t tick_hz);

/// Check jerks and gains.
/// @return cam_ok, cam_err_jerk with the least jerk or cam_err_gain with the largest gain
CAM_MUST_USE cam_refusal_t cam_gains_check(const cam_params_t *params, uint32_t tick_hz);

/// Check the parameters servo_*, which make the position loop of U, and calculate the coefficients.
/// Nothing is checked while the port takes positions for U or servo_crossover_hz is 0.
/// @param cfg  result; all 0 where nothing is checked
/// @return     cam_ok, cam_err_servo (also where the delay of the force is less than the latency of
///             the port's output, or the mass too light for the supervision at this rate), or
///             cam_err_servo_force where U's limits need more than the force limit [mN]
CAM_MUST_USE cam_refusal_t cam_servo_setup(const cam_params_t *params, uint32_t tick_hz,
                                           cam_servo_config_t *cfg);

/// Changes: what the operator changes during a cut, as values per plan. The plan ramps the
/// overrides of feed and spindle and the trim of X: the feed by the ramps of cam_feed_motion_t, the
/// others by a step from plan to plan. Source: MATHS.md (175), (178), (179).

/// @return [1e-6] override of the feed in force: a smaller one than a hundredth counts as 0 and
///         holds the feed; always 1 for a measured Z
int32_t cam_changes_feed_ppm(const cam_params_t *params);

/// @param c  complete except for the operator's changes, which are filled in
void cam_changes_build(cam_play_config_t *c, const cam_params_t *params, uint32_t tick_hz);

#endif
