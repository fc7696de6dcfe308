// SPDX-License-Identifier: Apache-2.0
/// cam_lobe_transition: speed and acceleration of an axis between two lobes, where its lift falls
/// to 0 and rises again.
///
/// The shortest change between lobes takes N = change / feed turns. With the smooth step E of the
/// share s of the change, the largest magnitudes f, f1, f2 of a function of the angle and of its
/// derivatives at the table's speed ratio, the largest ratio R and the largest S of |r r'|, the
/// bounds over s are those of
///
///     E f1 + E' f x,    E f2 + 2 E' f1 x + n |E''| f x^2 + n E' f S x,    x = R / (2 pi N)
///
/// The amplitude moves in straight lines from plan to plan, so one set-point of n takes the bend of
/// all of them, that by the spindle's acceleration too. Between two twentieths of s the first term
/// is taken at the upper one, and the rest 1 % above the larger of both, which it does not exceed
/// in between. Source: MATHS.md (88). Context: slow side, integers only.
#ifndef CAM_LOBE_TRANSITION_H
#define CAM_LOBE_TRANSITION_H

#include "cam_table.h" // cam_table_t
#include <stdint.h>    // uint64_t

/// Largest magnitudes of a function over the angle, below 2^33.
typedef struct {
    uint64_t f;  ///< [unit]
    uint64_t f1; ///< [unit/rad] times the speed ratio
    uint64_t f2; ///< [unit/rad2] at the speed ratio
} cam_lobe_transition_peaks_t;

/// @param t        with or without lobes
/// @param feed_nm  [nm] per turn, below 2^24
/// @return         [unit/rad] bound of the speed over the mean speed, at least f1
uint64_t cam_lobe_transition_first(const cam_table_t *t, uint64_t feed_nm,
                                   const cam_lobe_transition_peaks_t *peaks);

/// @param n_set_points  of the axis from plan to plan, 1 .. 80
/// @return              [unit/rad2] bound of the acceleration over the mean speed squared, at least
///                      f2
uint64_t cam_lobe_transition_second(const cam_table_t *t, uint64_t feed_nm,
                                    const cam_lobe_transition_peaks_t *peaks,
                                    uint32_t n_set_points);

#endif
