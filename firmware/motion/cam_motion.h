// SPDX-License-Identifier: Apache-2.0
/// cam_motion: laws of motion for axes, without a table.
///
/// Outside the cut an axis moves by time, to a position within speed and acceleration, and with a
/// limit of the jerk. In the cut, depth and amplitude rise and fall over the turns by the smooth
/// step, and Z may follow a ring-helix. A test wave identifies U's drive. The parts stand in this
/// order, and each uses at most those before it.
/// Context of all functions: ISR, constant time, cannot fail, unless noted.
#ifndef CAM_MOTION_H
#define CAM_MOTION_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, int64_t, uint32_t

/// Motion within speed and acceleration, tick by tick. Used, with the jerk limit below, wherever an
/// axis does not follow the spindle: approach, retract, stop after a fault; without it for the gain
/// of a wave. No square root, no division: a step is accepted if the axis can still brake to the
/// target, MATHS.md (60). Positions are nm / 1024 (q10), speeds nm / 1024 per tick.

typedef struct {
    int32_t speed_q10;        ///< [nm / 1024 per tick] > 0
    int32_t acceleration_q10; ///< [nm / 1024 per tick^2] > 0
    uint32_t log2_window;     ///< 0 .. cam_jerk_filter_most_log2, for the jerk filter: 2^this ticks
                              ///< share a change of acceleration
} cam_motion_limits_t;

typedef struct {
    int64_t pos_q10;
    int32_t vel_q10;
    int32_t acc_q10; ///< [nm / 1024 per tick^2] of the last step
} cam_axis_motion_t;

/// One tick towards a target. Speed stays within the limit (after braking, if it starts beyond) and
/// its change within the acceleration. Overshoots by at most acceleration_q10 / 8 unless the
/// initial speed makes more unavoidable.
/// @return true when the axis rests at the target
/*@ requires valid: \valid(m) && \valid_read(limits) && \separated(m, limits);
    requires limits: 0 <= limits->speed_q10 <= 0x40000000 &&
      0 <= limits->acceleration_q10 <= 0x40000000;
    assigns *m, \result \from *m, *limits, target_q10;
    behavior usual:
      assumes \abs(m->vel_q10) <= 0x3FFFFFFF;
      assumes \abs(m->pos_q10) <= 0x1000000000000000 && \abs(target_q10) <= 0x1000000000000000;
      ensures most: \abs(m->vel_q10) <=
        \max(limits->speed_q10, \abs(\old(m->vel_q10)) - limits->acceleration_q10);
      ensures change: \abs(m->vel_q10 - \old(m->vel_q10)) <= limits->acceleration_q10;
      ensures acceleration: m->acc_q10 == m->vel_q10 - \old(m->vel_q10);
      ensures step: m->pos_q10 == \old(m->pos_q10) + m->vel_q10;
      ensures there: \result <==> m->pos_q10 == target_q10 && m->vel_q10 == 0;
*/
bool cam_move_profile_to_isr(cam_axis_motion_t *m, const cam_motion_limits_t *limits,
                             int64_t target_q10);

/// One tick of braking to rest.
/// @return true when the axis rests
/*@ requires valid: \valid(m) && \valid_read(limits) && \separated(m, limits);
    requires limits: 0 <= limits->acceleration_q10 <= 0x40000000;
    assigns *m, \result \from *m, *limits;
    ensures slower: \abs(m->vel_q10) ==
      \max(0, \abs(\old(m->vel_q10)) - limits->acceleration_q10);
    ensures change: \abs(m->vel_q10 - \old(m->vel_q10)) <= limits->acceleration_q10;
    ensures acceleration: m->acc_q10 == m->vel_q10 - \old(m->vel_q10);
    ensures rest: \result <==> m->vel_q10 == 0;
    behavior usual:
      assumes \abs(m->pos_q10) <= 0x1000000000000000;
      ensures step: m->pos_q10 == \old(m->pos_q10) + m->vel_q10;
*/
bool cam_move_profile_stop_isr(cam_axis_motion_t *m, const cam_motion_limits_t *limits);

/// Motion within speed, acceleration and jerk. The set-point is the moving average of the last n
/// set-points of a motion without jerk limit. An average is never faster and never accelerates more
/// than its input, so those limits still hold; the acceleration changes by at most 2 a / n per
/// step, and the axis rests exactly at the same position, n steps later.
///
///     raw speed    ___/``\___           speed    __/``\__           jerk <= 2 a / n
///                   cam_move_profile            mean of the last n
///
/// A filtered motion may begin at speed, for example in the tick of a fault. Its earlier speeds are
/// then assumed to follow a straight line with the initial speed and acceleration. They are
/// calculated one by one as they leave the window, which needs no loop.
/// Source: MATHS.md (210), (211).

enum { cam_jerk_filter_most_log2 = 6 }; ///< n is a power of two, at most 64

/// State, made by cam_jerk_filter_begin_isr(). Zero-initialised it rests at 0.
typedef struct {
    cam_axis_motion_t raw;       ///< the motion before the filter
    int64_t sum_pos_q10;         ///< of the last n positions of raw
    int64_t sum_vel_q10;         ///< ... of its speeds
    int32_t line_q10, slope_q10; ///< next speed of the line to leave; its change
    uint32_t n_line;             ///< speeds of the line still in the window
    uint32_t n_still;            ///< steps since raw rests at its target, at most n
    uint32_t log2_window;        ///< n = 2^this
    uint32_t at;                 ///< steps, wraps
    int32_t past_q10[1 << cam_jerk_filter_most_log2]; ///< raw speeds of the last n steps
} cam_jerk_filter_t;

/// @return [nm / 1024 per step^2] largest initial acceleration for a window, so that the change of
/// speed over the window fits a word; a larger one is limited to it
static inline int32_t cam_jerk_filter_most_q10(uint32_t log2_window)
{
    return (INT32_C(1) << 30) >> log2_window;
}

/// Begin at the position, speed and acceleration of an axis.
/// @param m            the axis after its last step
/// @param log2_window  0 .. cam_jerk_filter_most_log2
void cam_jerk_filter_begin_isr(cam_jerk_filter_t *g, const cam_axis_motion_t *m,
                               uint32_t log2_window);

/// One step towards a target. Overshoots by at most acceleration_q10 / 8 unless the initial speed
/// makes more unavoidable.
/// @param m       the axis after its last step; then after this one
/// @param limits  a changed window takes effect at the next rest
/// @return        true when the axis rests at the target
bool cam_jerk_filter_to_isr(cam_jerk_filter_t *g, cam_axis_motion_t *m,
                            const cam_motion_limits_t *limits, int64_t target_q10);

/// One step of braking to rest.
/// @return true when the axis rests
bool cam_jerk_filter_stop_isr(cam_jerk_filter_t *g, cam_axis_motion_t *m,
                              const cam_motion_limits_t *limits);

/// Shift the origin of the axis from the next step on.
void cam_jerk_filter_shift_isr(cam_jerk_filter_t *g, int64_t by_q10);

/// The smooth step by which depth and amplitude rise and fall, MATHS.md (55). The quintic step over
/// some turns starts and ends without a jump in speed. A drive with a lag would arrive late; it is
/// commanded the inverse of its own motion, MATHS.md (58).

/// Quintic smooth step 10 s^3 - 15 s^4 + 6 s^5.
/// @param s_q31  [1 / 2^31] 0 .. 2^31 - 1
/// @return       [1 / 2^30] 0 .. 2^30, error below 2^-24
int32_t cam_envelope_smooth_q30(int32_t s_q31);

/// Command that makes a drive follow the smooth step over a length. A lag of up to a sixteenth of
/// the length is inverted, which overshoots the end by at most 12 / 16^3 of the step; the rest of a
/// longer lag is compensated by reading ahead.
/// @param done_q32        [turn] since the start of the step; any value
/// @param lag_q32         [turn] travelled during the lag of the drive
/// @param length_q32      [turn] of the step, up to 100 turns
/// @param per_length_q31  [1/turn] its reciprocal
/// @return                [1 / 2^30] 0 before the step, 2^30 after it
int32_t cam_envelope_step_q30(int64_t done_q32, int64_t lag_q32, int64_t length_q32,
                              uint32_t per_length_q31);

/// Z over the turns of a ring-helix: one closed ring per section of the drawing, then one turn of
/// helix to the next section. Sections are one feed apart; the last step is the remainder of the
/// height. m rings take 2 m - 1 turns. In a helix turn Z's speed is a trapezoid: it rises over the
/// share r of the turn, stays at feed n / (1 - r) at n turns per second, and falls over r, with
/// acceleration feed n^2 / (r (1 - r)). r is the smallest value that the acceleration allows, at
/// least 1/256. Source: MATHS.md (40) .. (42); the generator's path.py has the same law. Context:
/// ISR for cam_feed_ring_end_q32() and the functions ending in _isr, slow side for all others.

enum { cam_feed_least_nm = 4 }; ///< [nm] least distance of sections: turns fit 30 bits

/// A ring-helix, made by cam_feed_rings().
typedef struct {
    bool is_on;            ///< false: Z follows a plain helix, or is measured
    uint32_t ramp_q32;     ///< [turn] r, 1/256 .. 1/2
    uint32_t per_ramp_q24; ///< [1/turn] its reciprocal
    uint32_t per_rest_q30; ///< [1] 1 / (1 - r)
    int32_t feed_nm;       ///< [nm] distance of the sections
    int32_t span_nm;       ///< [nm] from the first ring to the last
} cam_rings_t;

/// @param feed_nm                 [nm] 1 .. 10^7, at least cam_feed_least_nm is taken
/// @param speed_mrpm              [r/min / 1000] up to 6 * 10^7
/// @param acceleration_mm_per_s2  [mm/s2] of Z, 10 .. 10^6
/// @return  [turn / 2^32] shortest ramp, at most 2^-28 turn too long below 0.49, at most 1/2
uint32_t cam_feed_ramp_q32(uint32_t feed_nm, uint32_t speed_mrpm, uint32_t acceleration_mm_per_s2);

/// @return [um/s] highest speed of Z with that ramp, rounded up
uint64_t cam_feed_speed_um_per_s(uint32_t feed_nm, uint32_t speed_mrpm, uint32_t ramp_q32);

/// @return [mm/s2] least that any ramp needs, 4 feed n^2, rounded up
uint64_t cam_feed_least_acceleration(uint32_t feed_nm, uint32_t speed_mrpm);

/// @param span_nm  [nm] height of the part, 1 .. 2 * 10^9
/// @return a ring-helix; other parameters as of cam_feed_ramp_q32()
cam_rings_t cam_feed_rings(uint32_t feed_nm, int32_t span_nm, uint32_t speed_mrpm,
                           uint32_t acceleration_mm_per_s2);

/// @return [turn / 2^32] length: 2 m - 1 turns, below 2^62
int64_t cam_feed_turns_q32(const cam_rings_t *rings);

/// @param done_q32  [turn / 2^32] since the first ring began, 0 .. the length
/// @return          [nm] Z above the first ring, 0 .. span, with an error of the step's 2^-26
int32_t cam_feed_height_nm_isr(const cam_rings_t *rings, int64_t done_q32);

/// A path that ends early still ends with a closed ring: the present one, or that after the helix.
/// @param done_q32  [turn / 2^32] whole turns, above 0
/// @return          [turn / 2^32] length of such a path, at most a turn more
static inline int64_t cam_feed_ring_end_q32(int64_t done_q32)
{
    return (int64_t)((uint64_t)done_q32 | UINT64_C(1) << 32);
}

/// A test wave on U, of positions or of forces. In the state identifying U moves to a position and
/// rests; then a wave from memory is added to its set-point, times a gain that rises from 0 to 1
/// and falls to 0 again with limited speed and acceleration. The wave has no feed-forward. After
/// n_play ticks the gain falls; when it rests at 0 the excitation is over. An earlier end makes the
/// gain fall at once. A wave of force is added to the force of U instead, and U's set-point rests.
/// It ends without a fall, from one tick to the next. The slow side has checked the wave
/// (cam_machine_excite()): at any gain the set-point stays within stroke, speed and acceleration of
/// U.

enum { cam_excite_full_q30 = 1 << 30 }; ///< gain 1

/// The wave; n = 0: none, the request is ignored.
typedef struct {
    const int32_t *wave;      ///< [nm], or [mN] of force; samples of a period, one per tick
    uint32_t n;               ///< [ticks] samples of the period
    uint32_t first;           ///< first sample to be played
    uint32_t n_play;          ///< [ticks] until the gain falls, its rise included
    cam_motion_limits_t fade; ///< [2^-30 per tick, per tick^2] of the gain
    int64_t place_q10;        ///< [nm / 1024] position of U about which it is played
    bool is_force;            ///< the samples are forces
} cam_excite_config_t;

/// State; zero-initialised: over. It begins with `at` and `n_left` of the configuration and gain 0;
/// n_left = 0 starts the fall.
typedef struct {
    uint32_t at;            ///< next sample
    uint32_t n_left;        ///< [ticks] until the gain falls
    cam_axis_motion_t gain; ///< pos_q10 is [2^-30]
} cam_excite_t;

/// One tick, with U at rest apart from the wave.
/// @param offset_q6  result, [nm / 64] to be added to the set-point of U, or [mN / 64] to its force
/// @return           true when the gain rests at 0 after the end, or a force has ended
bool cam_excite_step_isr(cam_excite_t *e, const cam_excite_config_t *cfg, int32_t *offset_q6);

#endif
