// SPDX-License-Identifier: Apache-2.0
/// cam_feasible_inner: the demands of a cut and the design of the position loop, private to this
/// room.
///
/// Read the cut and its arithmetic first, then the demands: U's command with feed-forward, the
/// motion of Z with its effect on the other axes. The design of the position loop stands alone.
///
/// Demands are calculated in doubles and rounded up, so that none is too small.
/// Context of all functions: slow side.
#ifndef CAM_FEASIBLE_INNER_H
#define CAM_FEASIBLE_INNER_H

#include "cam_doubles.h"  // CAM_PI
#include "cam_err.h"      // CAM_MUST_USE
#include "cam_feasible.h" // cam_demand_t, cam_demands_t
#include "cam_fix.h"      // cam_abs_i64
#include "cam_param.h"    // cam_params_t
#include "cam_servo.h"    // cam_servo_config_t
#include "cam_table.h"    // cam_table_t
#include <stdint.h>       // int32_t, int64_t, uint32_t, uint64_t

/// A cut at a mean speed of the spindle.
typedef struct {
    const cam_table_t *t;
    const cam_params_t *p;
    uint32_t tick_hz;   ///< [Hz] rate of the tick
    uint32_t mean_mrpm; ///< [r/min / 1000] mean speed, below 2^26
    uint32_t peak_mrpm; ///< [r/min / 1000] highest speed within a turn, up to four times the mean
    uint64_t feed_nm;   ///< [nm] feed per turn, override included, below 2^25
    uint64_t programmed_nm; ///< [nm] without the override: the ramps of the feed are made for it
} cam_cut_t;

/// @return v rounded up, saturated to 0 .. INT64_MAX, INT64_MAX for NaN; what exceeds an integer by
///         less than 2^-40 of itself is rounding
static inline uint64_t cam_cut_up(double v)
{
    if (!(v < 0x1p62)) {
        return (uint64_t)INT64_MAX;
    }
    if (v <= 0.0) {
        return 0;
    }
    const uint64_t whole = (uint64_t)v;
    return v - (double)whole > v * 0x1p-40 ? whole + 1u : whole;
}

static inline double cam_cut_most(double a, double b)
{
    return a > b ? a : b;
}

/// @return a peak of U or of the swing at the amplitude in force
static inline double cam_cut_at_amplitude(const cam_cut_t *c, double peak)
{
    return peak * c->p->amplitude_ppm * 1e-6;
}

/// @return [rad/s] of r/min / 1000
static inline double cam_cut_omega(uint32_t mrpm)
{
    return mrpm * (CAM_PI / 30000.0);
}

/// @return [um/s] of a derivative in nm/rad at the mean speed of the spindle
static inline double cam_cut_um_per_s(const cam_cut_t *c, double peak)
{
    return peak * cam_cut_omega(c->mean_mrpm) * 1e-3;
}

/// @return [mm/s2] of a second derivative in nm/rad2, likewise
static inline double cam_cut_mm_per_s2(const cam_cut_t *c, double peak)
{
    const double omega = cam_cut_omega(c->mean_mrpm);
    return peak * omega * omega * 1e-6;
}

/// The smooth step of the envelope and of lobes, and the magnitudes of its derivatives.
typedef struct {
    double e, e1, e2;
} cam_cut_step_t;

/// @param s  0 .. 1
static inline cam_cut_step_t cam_cut_step(double s)
{
    const double left = 1.0 - s;
    return (cam_cut_step_t){
        .e = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s),
        .e1 = 30.0 * s * s * left * left,
        .e2 = 60.0 * s * left * (left > s ? left - s : s - left),
    };
}

/// @return [nm] how far U travels from the middle of its stroke, without feed-forward
static inline uint64_t cam_cut_largest_nm(const cam_table_t *t)
{
    return cam_greater_u64((uint64_t)cam_abs_i64(t->u_min_nm), (uint64_t)cam_abs_i64(t->u_max_nm));
}

/// @return [nm] height of the part, over which Z feeds
static inline uint64_t cam_cut_span_nm(const cam_cut_t *c)
{
    return (uint64_t)((int64_t)c->t->z_last_nm - c->t->z_first_nm);
}

/// What a cut demands of every axis. Source: MATHS.md (61) .. (64), (42), (44).
cam_demands_t cam_demand_all(const cam_cut_t *c);

/// @return the first limit that the cut exceeds; err = cam_ok when it exceeds none
cam_demand_t cam_demand_first_exceeded(const cam_cut_t *c);

/// How far and how fast U is commanded, feed-forward included. At the speed omega the command is
/// u + k1 u' omega + k2 u'' omega^2 (cam_axis_command.c), so it may leave a stroke that contains u,
/// and move faster than u. Source: MATHS.md (213), (215), (216).

/// Bound the command by the peaks of the table. If this bound leaves the stroke, at a speed that
/// the spindle reaches, read all knots: u and u' seldom peak at the same angle.
/// @return [nm] the largest distance of U's command from the middle of its stroke. This demand and
///         the next two are 0 without gains.
cam_demand_t cam_command_stroke_demand(const cam_cut_t *c);

/// @return [um/s] the sum of the peaks of u' omega, k1 u'' omega^2 and k2 u''' omega^3 (0 for a
///         table with a speed channel). The limit follows from the limits and gains of U.
cam_demand_t cam_command_speed_demand(const cam_cut_t *c);

/// @return [mm/s2] the sum of the peaks of u'' omega^2 and k1 u''' omega^3, likewise
cam_demand_t cam_command_acceleration_demand(const cam_cut_t *c);

/// Motion of Z in a cut, and its effect on the motion of the other axes.
///
/// Along a helix Z moves evenly except in its ramps and where the table changes the feed; along a
/// ring-helix it rests in every other turn. While it moves, U and the swing also change from slice
/// to slice of the table: they drift. The rate of this drift jumps at each slice, and the
/// acceleration of the jump, spread over one set-point, is added.
///
/// Between two lobes of a shaft the lift of an axis falls to 0 and rises again. The shortest change
/// takes N = change / feed turns. With the smooth step E of the share s of the change, the largest
/// magnitudes f, f1, f2 of a function of the angle and of its derivatives at the table's speed
/// ratio, the largest ratio R and the largest S of |r r'|, the bounds over s are those of
///
///     E f1 + E' f x,    E f2 + 2 E' f1 x + n |E''| f x^2 + n E' f S x,    x = R / (2 pi N)
///
/// The amplitude moves in straight lines from plan to plan, so one set-point of n takes the bend of
/// all of them, that by the spindle's acceleration too. Between two twentieths of s the first term
/// is taken at the upper one, and the rest 1 % above the larger of both, which it does not exceed
/// in between. Source: MATHS.md (63), (64), (88), (104).

/// Effect of the feed on an axis, in thousands of the unit of its channel: um for u.
typedef struct {
    double speed;         ///< [1/s]
    double speed_per_rad; ///< [1/s/rad] how the speed differs over the angle
    double acceleration;  ///< [1/s2]
} cam_z_coupling_t;

/// @return [um/s] highest speed of Z; on a ring-helix that between its ramps
double cam_z_coupling_z_um_per_s(const cam_cut_t *c);

/// On a helix Z accelerates with feed * (turns per second)^2 / ramp, where a ramp is not longer
/// than the height that is fed. On a ring-helix the ramps are as short as the limit allows, so that
/// only the least acceleration that any ramp needs can exceed it.
/// @return [mm/s2]
double cam_z_coupling_z_mm_per_s2(const cam_cut_t *c);

/// @return [mm/s2] acceleration of Z that the other axes have to follow. A measured Z is not
///         accelerated by this controller, and is taken as moving evenly.
double cam_z_coupling_z_feeding_mm_per_s2(const cam_cut_t *c);

/// @return [um/s] speed along the heights of the table: with stations that of the helix, not of Z
double cam_z_coupling_along_um_per_s(const cam_cut_t *c);

/// @return [mm/s2] its acceleration
double cam_z_coupling_along_mm_per_s2(const cam_cut_t *c);

/// Bound the drift of a channel. Slices pass at the speed of Z over their spacing. The rate of
/// change jumps from one slice to the next, and an axis takes the jump within one set-point; while
/// Z accelerates the rate rises as well. Patterns of lobes have no spacing, and do not drift.
/// @param set_point_hz  [Hz] rate of the axis's set-points
cam_z_coupling_t cam_z_coupling_of(const cam_cut_t *c, const cam_channel_t *ch,
                                   const cam_change_t *change, uint32_t set_point_hz);

/// @return [1/s2] effect of a drift on an acceleration, with its difference over the angle
double cam_z_coupling_acceleration(const cam_cut_t *c, const cam_z_coupling_t *d);

/// Largest magnitudes of a function over the angle.
typedef struct {
    double f;  ///< [unit]
    double f1; ///< [unit/rad] times the speed ratio
    double f2; ///< [unit/rad2] at the speed ratio
} cam_z_coupling_peaks_t;

/// @param t        with or without lobes
/// @param feed_nm  [nm] per turn, below 2^24
/// @return         [unit/rad] bound of the speed over the mean speed, at least f1
double cam_z_coupling_lobes_first(const cam_table_t *t, uint64_t feed_nm,
                                  const cam_z_coupling_peaks_t *peaks);

/// @param n_set_points  of the axis from plan to plan, 1 .. 80
/// @return              [unit/rad2] bound of acceleration over mean speed squared, at least f2
double cam_z_coupling_lobes_second(const cam_table_t *t, uint64_t feed_nm,
                                   const cam_z_coupling_peaks_t *peaks, uint32_t n_set_points);

/// Design of the position loop: its coefficients from physical quantities. The loop crosses over
/// where a free mass without lag would: |C| m wc^2 = 1. Delay, amplifier and modes move the real
/// crossover; margins are the caller's concern (tools/camtools/tune). Coefficients are rounded to
/// nearest, within a unit of the last place (cam_servo_config_t gives the units).
/// Source: MATHS.md (233) .. (237).

/// Calculate the coefficients. Its `ahead` is for a set-point that is due when the force acts:
/// servo_force_delay_ns after the latch of the step.
/// @param step_hz  500 .. 200 000, rate of the loop
/// @param cfg      result, unspecified after a refusal
/// @return         cam_n_params, the first parameter that is beyond its bound by another one, or
///                 that whose coefficient overflows
CAM_MUST_USE cam_param_id_t cam_servo_design(const cam_params_t *p, int32_t step_hz,
                                             cam_servo_config_t *cfg);

/// @return [mN] force that U needs for mass, drag, friction and stiffness at the limits of its
///         acceleration, speed and stroke together; rounded up
int64_t cam_servo_needed_mn(const cam_params_t *params);

#endif
