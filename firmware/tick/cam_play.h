// SPDX-License-Identifier: Apache-2.0
/// cam_play: from master position to set-points of all axes, and the sequence of a cut.
///
/// While engaging, cutting and disengaging every axis is a function of the spindle angle:
///     U = amplitude * envelope * u(angle + lead - phase, Z)
///     Z = first height + feed * turns since feed start   eased in and out (or measured, or along
///         the ring-helix of cam_feed.h)
///     X = x(Z) + (1 - envelope) * clearance
///     spindle = mean speed, or mean * (1 + envelope * (ratio(angle, Z) - 1)) where the table
///               modulates it (cam_speed.h)
/// U is read in every tick, at the angle that the spindle will have when the drive's dead time has
/// passed. What changes slowly, all the rest, is planned in rounds of 21 ticks (cam_plan.h), X
/// and Z ahead by the lag of their drives. The envelope rises and falls by the quintic smooth step,
/// so depth and amplitude start and end without a jump in speed: MATHS.md (54), (55). In all other
/// states the axes move to places within their limits (cam_move.h). Context: ISR unless noted.
#ifndef CAM_PLAY_H
#define CAM_PLAY_H

#include "cam_eval.h"    // cam_place_t
#include "cam_feed.h"    // cam_rings_t
#include "cam_move.h"    // cam_move_t
#include "cam_speed.h"   // cam_speed_t
#include "cam_spindle.h" // cam_angle_t
#include "cam_state.h"   // cam_sense_t, cam_state_t
#include "cam_swing.h"   // cam_swing_t
#include "cam_table.h"   // cam_table_t
#include <stdbool.h>     // bool
#include <stdint.h>      // int32_t, int64_t

enum {
    cam_play_history = 64, ///< ticks of U kept to know what is due; a power of two
};

/// Tasks of cam_plan.h, one per tick. cam_round.h lays them out: most in this order, those of the
/// speed ratio once more at the end or not at all, those of the swing in between or not at all.
enum {
    cam_plan_task_positions, ///< where the master will be when the ways of this round end; the
                             ///< first
    cam_plan_task_turns,     ///< of feed until then
    cam_plan_task_feed,
    cam_plan_task_height,
    cam_plan_task_x_rise,
    cam_plan_task_x_fall,
    cam_plan_task_u_rise,
    cam_plan_task_u_fall,
    cam_plan_task_envelopes,
    cam_plan_task_find_profile,
    cam_plan_task_find_slices, ///< of the speed ratio
    cam_plan_task_find_ratio,
    cam_plan_task_ratio_knot_0,
    cam_plan_task_ratio_knot_1,
    cam_plan_task_read_ratio,
    cam_plan_task_ratio,
    cam_plan_task_pace,
    cam_plan_task_told,
    cam_plan_task_speed,
    cam_plan_task_alpha,
    cam_plan_task_alpha_u,
    cam_plan_task_read_profile,
    cam_plan_task_x,
    cam_plan_task_aim_x, ///< way of X
    cam_plan_task_aim_z, ///< way of Z
    cam_plan_task_find_height,
    cam_plan_task_hold_height, ///< on the table
    cam_plan_task_aim_height,  ///< way of U's height on the table
    cam_plan_task_aim_u,       ///< way of U's amplitude
    cam_plan_task_state,
    cam_plan_task_z,
    cam_plan_task_ramp,
    cam_plan_task_height_swing, ///< of the swing
    cam_plan_task_look_at_swing,
    cam_plan_task_find_swing, ///< a pass: from here to the last one
    cam_plan_task_place_swing,
    cam_plan_task_swing_knot_0,
    cam_plan_task_swing_knot_1,
    cam_plan_task_read_swing,
    cam_plan_task_aim_swing
};

/// Ticks of a round; beyond its own length what an index edge and a row of busy ticks take.
enum {
    cam_plan_put_off = 8,
    cam_plan_ratio_tasks = cam_plan_task_read_profile - cam_plan_task_find_slices,
    cam_plan_ticks_uniform = cam_plan_task_height_swing - cam_plan_ratio_tasks,
    cam_plan_ticks_modulated = cam_plan_ticks_uniform + 2 * cam_plan_ratio_tasks,
    cam_plan_ticks_swung = 95,
    cam_plan_most_ticks = 117, ///< swung and modulated
};
_Static_assert(cam_plan_ticks_uniform == 21 && cam_plan_ticks_modulated == 43,
               "as the documents say");

/// How far into the work at a planned position.
typedef struct {
    int64_t pos_q32;  ///< [turn] master position
    int32_t risen;    ///< [1 / 2^30] rising part of the envelope
    int32_t fallen;   ///< [1 / 2^30] falling part
    int32_t envelope; ///< [1 / 2^30] 0 out of the work, 2^30 at full depth and amplitude
} cam_plan_depth_t;

/// What the tasks of a round hand to one another.
typedef struct {
    cam_plan_depth_t xz;              ///< of X and Z
    cam_plan_depth_t u;               ///< of the amplitude of U
    int64_t free_q32;                 ///< [turn] a whole turn that no axis is told of for a round
    int64_t stop_turns_q32;           ///< [turn] length of the feed if it were stopped now
    int64_t stop_end_q32;             ///< [turn] ... and where the envelope would start to fall
    int64_t done_q32;                 ///< [turn] since the feed began, 0 .. its length
    int64_t fed_q32;                  ///< [turn] of feed until then
    uint32_t risen_q30;               ///< [1] ... of a ring-helix: of the step
    int32_t z_nm;                     ///< [nm] height then
    int32_t measured_nm, going_on_nm; ///< [nm] Z of the last round, and then if it goes on so
    cam_spot_t x_spot;
    cam_height_t u_height;
    int64_t u_height_q32; ///< [slices] the same with the ticks that were put off
    int32_t x_value;      ///< [LSB] X on the table
    int64_t x_q10;        ///< [nm / 1024] X
    cam_height_t ratio_height;
    uint32_t ratio_angle_q32; ///< [turn / 2^32] where the speed ratio is read
    cam_place_t ratio_place;
    cam_knot_t ratio_knot[2];
    cam_fine_t ratio_fine;
    cam_ratio_t ratio;
    cam_pace_t pace;
    uint32_t told_q28; ///< [1] share of the mean speed that the spindle is told
} cam_plan_t;

/// Powers of two that bring what the table says of U to nm / 64 and nm / 1024.
typedef struct {
    uint32_t speed_shift; ///< speed << this is below 2^30
    int32_t offset;       ///< value at p = 0 in the unit of y
    uint32_t scale_down;  ///< scale_q30 >> this makes the factor of y
    uint32_t y_up, v_up;  ///< shifts of the high words of the products
    uint32_t a_down;      ///< of d2 before, and
    uint32_t a_shift;     ///< of the product
    uint32_t alpha_shift;
} cam_u_scale_t;

/// Configuration, made by cam_config_build().
typedef struct {
    const cam_table_t *table; ///< NULL: none, enable is refused
    cam_u_scale_t u;
    uint8_t schedule[cam_plan_most_ticks + 1]; ///< tasks of a round, then the first one again
    int32_t round_ticks;                       ///< [ticks] length of a round
    int32_t x_early_ticks;                     ///< [ticks] X's way ends this much before Z's
    int32_t per_round_q32;                     ///< [1 / ticks] its reciprocal
    int32_t most_put_off;                      ///< [ticks] without a task on top; more are a fault
    int32_t lead_q16;                ///< [ticks] dead time of U, below cam_play_history - 2
    uint32_t lead_ticks;             ///< [ticks] whole ones of it
    int32_t lead_part_q31;           ///< [ticks / 2^31] the rest
    int32_t xz_lag_q16;              ///< [ticks] lag of X and Z
    int32_t u_plan_q16, xz_plan_q16; ///< [ticks] ... and those to the end of a plan
    int32_t told_q16;                ///< [ticks] what any axis is told of before the next plan
    int32_t free_q16;                ///< [ticks] ... and before it is known where a stop ends
    int32_t ratio_q16;               ///< [ticks] the speed ratio is read this much ahead
    int32_t u_behind_q16;            ///< [ticks] U is read this much behind X and Z
    int64_t height_max_q32;          ///< [slices] end of the table for U
    int32_t u_height_q16;            ///< [ticks] from the planned height to that of U's plan
    int32_t xz_lag2; ///< [ticks^2] what the acceleration of the spindle adds to X and Z until then
    int32_t phase_q32, phase_step_q32;          ///< [turn / 2^32], per tick
    int32_t amplitude_q30, amplitude_step_q30;  ///< [1], per tick
    int64_t engage_q32, disengage_q32;          ///< [turn] lengths
    uint32_t per_engage_q31, per_disengage_q31; ///< [1/turn] their reciprocals
    int64_t feed_q32;            ///< [turn] from first to last height, ramps included
    int64_t ramp_q32;            ///< [turn] over which the feed rises, and falls
    uint32_t per_ramp_q31;       ///< [1/turn] its reciprocal
    cam_rings_t rings;           ///< off: the feed is that of a helix
    int32_t feed_nm;             ///< [nm] per turn
    int32_t z_first_nm;          ///< [nm] where the feed starts
    int32_t z_low_nm, z_high_nm; ///< [nm] range accepted from a measured Z
    int32_t z_margin_nm;         ///< [nm] accepted distance of a geared Z from its place
    int32_t turning_q32;         ///< [turn / 2^32 per tick] slower does not count as turning
    bool is_z_measured;
    int64_t u_retract_q10;                  ///< [nm / 1024]
    int32_t x_clearance_nm;                 ///< [nm]
    cam_move_limits_t approach[hal_n_axes]; ///< gentle limits outside the cut
    int32_t spindle_mrpm;                   ///< mean set-point, signed by the table's direction
    cam_speed_config_t speed;               ///< modulation, of a table with a speed channel
    cam_swing_config_t swing;               ///< of a table that swings the tool
} cam_play_config_t;

/// State; zero-initialised is off.
typedef struct {
    cam_state_t state;
    uint32_t request;            ///< serial number of the last one carried out
    bool is_playing;             ///< in the work and not approaching it: axes follow the table
    bool is_retracted;           ///< in state fault: the guard's retract has ended
    cam_move_t axis[hal_n_axes]; ///< set-points written last
    uint32_t task;               ///< place in the schedule of the next tick; step of an approach
    int32_t put_off_left;        ///< [ticks] that this round may still have without a task
    int64_t engage_at_q32;       ///< [turn] master position where the envelope starts to rise
    int64_t feed_at_q32;         ///< ... where Z starts
    int64_t disengage_at_q32;    ///< ... where the envelope starts to fall
    int64_t feed_turns_q32;      ///< [turn] length of the feed, shorter after a stop
    cam_plan_t plan;
    int64_t height_q32;                   ///< [slices] U's height on the table
    int32_t height_way_q32;               ///< per tick
    bool is_height_free;                  ///< its way may last longer and stays on the table
    int32_t behind_q4, behind_way_q4;     ///< [nm / 16] U is played this much behind Z, per tick
    int32_t phase_q32, phase_way_q32;     ///< [turn / 2^32], per tick
    int32_t amplitude_q30;                ///< ramped
    int32_t scale_q30, scale_way_q30;     ///< [1] amplitude * envelope, per tick
    cam_speed_t speed;                    ///< what the spindle is told in this tick
    int32_t alpha_u;                      ///< its acceleration in the unit of U's
    int32_t history_q6[cam_play_history]; ///< [nm / 64] U set-points
    uint32_t n_history;                   ///< ticks
    int32_t due_q6;                       ///< [nm / 64] the one of them that was looked up last
    cam_swing_t swing;
} cam_play_t;

/// What play wants of the machine, besides the axes; then what the guard made of it.
typedef struct {
    cam_state_t state;
    bool is_retracted; ///< guard: tool at rest out of the work
    int32_t z_nm;      ///< [nm] height played
    int32_t u_set_q6;  ///< [nm / 64] U at the tool
    int32_t u_due_q6;  ///< [nm / 64] where U should be now
    int32_t spindle_mrpm;
    uint32_t faults;  ///< play: z_range, table; guard: latched
    uint32_t outputs; ///< guard: hal_out_*
} cam_want_t;

/// One tick of the sequence.
/// @param cfg    configuration with a table, unless the state is off or fault
/// @param in     what this tick sensed, with the request of the slow side
/// @param angle  the spindle
/// @param want   result
/// Constant time in each state; states that play the table are the longest.
CAM_STAGE void cam_play_step_isr(cam_play_t *p, const cam_play_config_t *cfg, const cam_sense_t *in,
                                 const cam_angle_t *angle, cam_want_t *want);

/// The guard is in state fault: so is play.
static inline void cam_play_settle_isr(cam_play_t *p, bool is_retracted)
{
    p->state = cam_state_fault;
    p->is_playing = false;
    p->is_retracted = is_retracted;
}

#endif
