// SPDX-License-Identifier: Apache-2.0
/// cam_derived_limits: numbers that follow from machine and part where none was set, and what a
/// tick allows.
///
/// A parameter whose default is 0, "derived", has no number that fits every machine: the jump
/// window scales with the encoder, the following error with the part. Context: slow side, integers
/// only.
#ifndef CAM_DERIVED_LIMITS_H
#define CAM_DERIVED_LIMITS_H

#include "cam_err.h"   // cam_err_t
#include "cam_param.h" // cam_params_t, cam_param_id_t
#include "cam_table.h" // cam_table_t
#include <stdint.h>    // int32_t, uint32_t

/// [Hz] rate of a tick from which on a measured U is young enough for a limit that follows from the
/// part. Slower ticks are those of field buses, whose measurements are some ticks old.
enum { cam_derived_limits_least_hz = 10000 };

/// Out of the cut every axis takes this share of its speed and of its acceleration: a quarter.
enum { cam_derived_limits_approach_share = 4 };

/// The most that counts of one tick may deviate from what the observer expects: what a spindle that
/// accelerates as fast as it can and ripples by a hundredth of its highest speed makes of it,
/// twice, 4 counts of quantisation, and index_tolerance_counts for the encoder's jitter; at least 8
/// counts and the jitter.
/// @return [counts] jump_window_counts, or where that is 0 the derived one, at most 2^30
/// Source: MATHS.md (166).
int32_t cam_derived_limits_jump_counts(const cam_params_t *params, uint32_t tick_hz);

/// The accepted following error of U in the cut: a fifth of its travel in the table at the present
/// amplitude, which of an oval is a tenth of the ovality; at least 0.01 mm, at most 0.2 mm. Without
/// k1 nothing is known of the drive, and 0.1 mm is the least.
/// @param table  NULL: none is selected, and U does not cut
/// @return [nm] following_limit_nm, or where that is 0 the derived one
int32_t cam_derived_limits_following_nm(const cam_params_t *params, const cam_table_t *table);

/// The accepted following error of U out of the cut: that of the cut, but not less than what the
/// drive may be off in its approach when half of its lag is not what was believed, and its
/// measurement half a tick old.
/// @return [nm] following_limit_nm, or where that is 0 the derived one
/// Source: MATHS.md (167).
int32_t cam_derived_limits_approach_nm(const cam_params_t *params, const cam_table_t *table,
                                       uint32_t tick_hz);

/// @return [mHz] the bandwidth of the observer where none is set: a twentieth of the tick's rate,
/// at
///         which a tick moves its angle by two thirds of an error, or the wanted one where that is
///         less
int32_t cam_derived_limits_usual_mHz(int32_t wanted_mHz, uint32_t tick_hz);

/// @return the largest value of a parameter that fits the rate of the tick, and for the speeds of X
///         and Z what the port's outputs pass on; for parameters that depend on neither, their
///         largest value
int32_t cam_derived_limits_most(cam_param_id_t id, uint32_t tick_hz);

/// Check what the interrupt relies on: the history reaches back over the lead and the latency of
/// U's scale, the observer is slower than the tick, feed-forward gains fit 15 integer bits.
/// The speeds of X and Z are such that their outputs pass them on.
/// The feed-forward tells U no more than its limits allow, and jerks have a window (cam_gains.h).
/// @return cam_ok, cam_err_param_tick, cam_err_param_output, cam_err_jerk or cam_err_gain
CAM_MUST_USE cam_err_t cam_derived_limits_check(const cam_params_t *params, uint32_t tick_hz);

#endif
