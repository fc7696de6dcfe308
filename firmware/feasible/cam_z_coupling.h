// SPDX-License-Identifier: Apache-2.0
/// cam_z_coupling: motion of Z in a cut, and its effect on the motion of the other axes.
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
/// in between. Context: slow side. Source: MATHS.md (63), (64), (88), (104).
#ifndef CAM_Z_COUPLING_H
#define CAM_Z_COUPLING_H

#include "cam_cut.h" // cam_cut_t
#include <stdint.h>  // uint32_t, uint64_t

/// Effect of the feed on an axis, in thousands of the unit of its channel: um for u.
typedef struct {
    double speed;         ///< [1/s]
    double speed_per_rad; ///< [1/s/rad] how the speed differs over the angle
    double acceleration;  ///< [1/s2]
} cam_z_coupling_t;

/// @return [um/s] highest speed of Z; on a ring-helix that between its ramps
double cam_z_coupling_z_um_per_s(const cam_cut_t *c);

/// On a helix Z accelerates with feed * (turns per second)^2 / ramp, where a ramp is not longer
/// than the height that is fed. On a ring-helix the ramps are as short
/// as the limit allows, so that only the least acceleration that any ramp needs can exceed it.
/// @return [mm/s2]
double cam_z_coupling_z_mm_per_s2(const cam_cut_t *c);

/// @return [mm/s2] acceleration of Z that the other axes have to follow. A measured Z is not
///         accelerated by this controller, and is taken as moving evenly.
double cam_z_coupling_z_feeding_mm_per_s2(const cam_cut_t *c);

/// @return [um/s] speed of X along its profile: with stations along the helix, not Z
double cam_z_coupling_x_um_per_s(const cam_cut_t *c);

/// @return [mm/s2] its acceleration
double cam_z_coupling_x_mm_per_s2(const cam_cut_t *c);

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

#endif
