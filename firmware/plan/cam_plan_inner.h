// SPDX-License-Identifier: Apache-2.0
/// cam_plan_inner: the parts of a plan, private to this room.
///
/// In the cut: the wait for a steady spindle, the feed, the lobes of a shaft and the swing of the
/// tool. Out of the cut: motion from plan to plan, and the positions of all axes. Read them in this
/// order; the manuals of their states are in cam_plan.h.
/// Context of all functions: ISR, called by the plan only; constant time, cannot fail.
#ifndef CAM_PLAN_INNER_H
#define CAM_PLAN_INNER_H

#include "cam_config.h" // cam_play_config_t, cam_swing_limits_t
#include "cam_eval.h"   // cam_height_t, cam_eval_profile
#include "cam_fix.h"    // cam_mul_shift
#include "cam_motion.h" // cam_motion_limits_t
#include "cam_plan.h"   // cam_feed_motion_t, cam_shaft_t, cam_steady_t
#include "cam_record.h" // cam_motion_t, cam_swing_t
#include "cam_state.h"  // cam_state_t
#include "hal/hal.h"    // hal_axis_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t, int64_t, uint32_t

/// Wait for a steady spindle.
/// @param state     outside of the approach (engaging, rehearsing) everything is forgotten
/// @param pos_q32   [turn] master position
/// @param is_there  the axes are at their start
/// @return whether the cut or its rehearsal may begin; then everything is forgotten, too
bool cam_steady_isr(cam_steady_t *s, const cam_play_config_t *cfg, cam_state_t state,
                    int64_t pos_q32, bool is_there);

/// Schedule the feed of a whole part at the rate of the configuration, or at a lower one if the
/// part is too short for its ramps.
/// @param at_q32  [turn] master position where the feed begins, a whole turn
void cam_feed_motion_begin_isr(cam_feed_motion_t *c, const cam_play_config_t *cfg, int64_t at_q32);

/// @return [nm] Z above the first height at a master position, 0 .. height of the part
int32_t cam_feed_motion_fed_nm_isr(const cam_feed_motion_t *c, const cam_play_config_t *cfg,
                                   int64_t pos_q32);

/// Apply the rate of the configuration, which differs from c->requested_q30. Called in every plan
/// until it is applied: during a ramp a new rate stays pending.
/// @param now_q32   [turn] master position; earlier positions are never read again
/// @param next_q32  [turn] first whole turn that is not yet commanded
void cam_feed_motion_request_isr(cam_feed_motion_t *c, const cam_play_config_t *cfg,
                                 int64_t now_q32, int64_t next_q32);

/// End the feed early. A moving feed ends its present ramp and brakes as steeply as Z and X can; a
/// ring-helix continues to the end of the next ring; a feed that has not begun never begins.
/// @param next_q32  as for cam_feed_motion_request_isr()
/// @return          [turn] where Z rests, at next_q32 or later
int64_t cam_feed_motion_stop_isr(cam_feed_motion_t *c, const cam_play_config_t *cfg,
                                 int64_t next_q32);

/// Lobes of a shaft. Between two lobes U moves down to the base circle and up again by smooth steps
/// over the height, MATHS.md (87). Pattern and phase change only at amplitude 0, so nothing jumps.
/// At uniform speed the lift falls over the whole transition. With a speed channel it falls over
/// the first half, and the speed ratio moves to 1 over the second, while U rests: the acceleration
/// limits of the table hold for both.

/// Select the lobe at the first height of a cut. Without lobes the phase is the operator's.
void cam_shaft_begin_isr(cam_shaft_t *s, const cam_table_t *t, int32_t z_nm, cam_motion_t *m);

/// Smooth a measured Z: between two lobes one step of its scale is many steps of U. The tracker has
/// no velocity error; after a jump of the speed by v per plan it lags by at most 5.3 v, below the
/// 20 um margin of a lobe up to 9 mm/s.
/// @return [nm] height for cam_shaft_plan_isr()
int32_t cam_shaft_smooth_isr(cam_shaft_t *s, int32_t z_nm);

/// Select the lobe at U's height. If Z is there early, U still moves to the base circle.
cam_share_t cam_shaft_plan_isr(cam_shaft_t *s, const cam_table_t *t, int32_t z_nm, cam_motion_t *m);

/// Swing of the tool about a lobe, linear from plan to plan.
///
///     swing = amplitude * envelope * swing(angle + lag - phase, Z)
///
/// Each plan evaluates the table for the end of its line and gives the drive a set-point with a
/// speed, at which the drive continues until the next one. A line deviates from the table by at
/// most a T^2 / 8, a the acceleration of the swing, T the period of the plan: 0.00043 degrees for
/// 21 600 degrees/s2 and 0.4 ms, MATHS.md (59).
///
/// The swing may rise and fall with the amplitude of U: the tool's tip runs on the roller's circle
/// at any swing, and with U and X in position that circle touches the lobe from outside. A wrong
/// swing leaves material but never cuts too deep. So U and X alone retract the tool, and the swing
/// returns to 0 at its own pace. To first order it is even correct meanwhile: a lobe of lift e H
/// has the pressure angle e gamma.
///
/// Outside the work the swing returns to 0 at a speed in proportion to the distance, within limits.

/// Plan the next line, starting at the end of the last one.
/// @param theta_q32  [turn / 2^32] angle of the spindle at its end, lag included, minus the phase
/// @param z          slice of the channel then
/// @param scale_q30  amplitude * envelope then
void cam_swing_plan_isr(cam_swing_t *s, const cam_play_config_t *cfg, uint32_t theta_q32,
                        cam_height_t z, int32_t scale_q30);

/// Check that the drive is where the line was one lag ago; the limit allows for a change of speed
/// meanwhile. Call it before planning the next line.
/// @param actual_q32  [turn / 2^32] measured
/// @return            fault swing or none
uint32_t cam_swing_check_isr(const cam_swing_t *s, const cam_play_config_t *cfg,
                             int32_t actual_q32);

/// One plan outside the work: the swing returns to 0 within its limits.
void cam_swing_rest_isr(cam_swing_t *s, const cam_play_config_t *cfg,
                        const cam_swing_limits_t *limits);

/// Without enable the set-point follows the measured swing.
void cam_swing_follow_isr(cam_swing_t *s, int32_t actual_q32);

/// Motion of an axis from plan to plan: linearly to a target, or within limits per plan. A motion
/// within limits runs the jerk filter of cam_motion.h once per plan. It begins with the present
/// speed of the axis and the last change of its speed, within the limits; the ticks interpolate
/// linearly.

enum { cam_plan_move_most_nm = 2147000000 }; ///< [nm] farthest position of an axis

/// @return increment per tick for a distance until the next plan
static inline int32_t cam_plan_move_share(const cam_play_config_t *cfg, int32_t left)
{
    return cam_mul_shift(left, cfg->per_plan_q30, 30);
}

/// Plan equal increments to a target; the remainder of the division is added at once. The distance
/// saturates at two millimetres per plan: a measured Z that moves faster is followed later. The
/// target is limited so that the position fits the drive's word.
static inline void cam_plan_move_line_isr(cam_axis_motion_t *m, const cam_play_config_t *cfg,
                                          int64_t target_q10)
{
    const int64_t most_q10 = (int64_t)cam_plan_move_most_nm * 1024;
    const int64_t held_q10 = cam_clamp_i64(target_q10, -most_q10, most_q10);
    const int32_t left_q10 = cam_sat_i32(cam_wrap_sub_i64(held_q10, m->pos_q10));
    m->vel_q10 = cam_plan_move_share(cfg, left_q10);
    m->acc_q10 = 0;
    const int64_t rest_q10 = left_q10 - (int64_t)m->vel_q10 * cfg->plan_ticks;
    m->pos_q10 = cam_wrap_add_i64(m->pos_q10, rest_q10);
}

/// @param trim_q4  [nm / 16] stock and trim in force
/// @return [nm / 1024] X over a height with its trim, plus (1 - envelope) of the clearance
static inline int64_t cam_plan_move_profile_q10(const cam_play_config_t *cfg, int32_t z_nm,
                                                int32_t envelope, int32_t trim_q4)
{
    const cam_channel_t *x = &cfg->table->x;
    const int64_t clear_q10 =
        ((int64_t)cfg->x_clearance_nm * ((INT32_C(1) << 30) - envelope)) >> 20;
    return ((int64_t)cam_eval_profile(x, z_nm).y * 1024 >> x->frac_bits) + cfg->x_offset_q10 +
           (int64_t)trim_q4 * 64 + clear_q10;
}

/// Move an axis towards a position, within limits in nm / 1024 per plan and per plan^2.
/// @return true when it rests there
bool cam_plan_move_to_isr(cam_motion_t *m, hal_axis_t axis, const cam_play_config_t *cfg,
                          const cam_motion_limits_t *limits, int64_t position_q10);

/// Brake an axis, likewise.
/// @return true when it rests
bool cam_plan_move_brake_isr(cam_motion_t *m, hal_axis_t axis, const cam_play_config_t *cfg,
                             const cam_motion_limits_t *limits);

/// Positions of all axes while they do not follow the table. In homing, ready, identifying, the
/// approach to a cut, and fault, X and Z move to positions or brake within their limits, one step
/// per plan; a measured Z is followed, and the swing returns to 0. U gets a target, to which the
/// ticks move it; in fault the guard retracts U. In off the swing follows its scale, as play makes
/// the other axes follow theirs. The end of homing is decided here.

/// One plan outside the cut.
/// @param m  increments, replaced from the next tick on
/// @return   true in the states rehearsing and engaging when all axes are at their start
/// Context: ISR, called by cam_plan_isr(); constant time in each state.
bool cam_positioning_isr(const cam_play_config_t *cfg, const cam_tick_record_t *r, cam_motion_t *m);

#endif
