// SPDX-License-Identifier: Apache-2.0
/// cam_ripple: deviation of the spindle from uniform rotation, learned over its angle.
///
/// The deviation of a revolution is the measured angle minus that of a uniform rotation of the same
/// duration, by the ticks in each bin. The mean over several revolutions is the ripple that the
/// encoder shows, its own eccentricity included, which is a parameter. Nothing is fed back.
/// Source: MATHS.md (146). Context: slow side.
#ifndef CAM_RIPPLE_H
#define CAM_RIPPLE_H

#include "cam_complex.h"   // cam_complex_t
#include "cam_harmonics.h" // cam_harmonics_most
#include "cam_turn_bins.h" // cam_turn_bin_t
#include <stdbool.h>       // bool
#include <stdint.h>        // int16_t, int32_t, uint32_t

/// [turn / 2^32] in a unit of the interrupt's tables, 2^-23 turn: 2^9.
enum { cam_ripple_down = 9 };

/// [turn / 2^23] limit of the sum of the orders' sizes: 12 mrad.
enum { cam_ripple_most = INT16_MAX / 2 };

/// State; zero-initialised has learned nothing.
typedef struct {
    cam_complex_t sum[cam_harmonics_most]; ///< [turn / 2^32] of orders 1 .. 16, over n turns
    struct {
        int16_t re;
        int16_t im;
    } mean[cam_harmonics_most]; ///< [turn / 2^23] ripple in force, as the encoder shows it
    int32_t first_q36;          ///< [turn / 2^36 per tick] speed of the first turn of the sum
    int32_t last_q36;           ///< ... and of the last one
    uint32_t n;                 ///< turns in the sum
    uint32_t n_mean;            ///< turns in the mean, 0: none
} cam_ripple_t;

/// Convert the sums of angle of a revolution to the deviation from uniform rotation, in place.
/// @param bin  128 bins of a turn, each with its sum of angle_q24 and n; angle becomes the
///             deviation in turn / 2^32, less a constant
/// @return     [turn / 2^36 per tick] mean speed; 0 where a bin is empty or the deviation is too
///             large: the turn must be discarded
int32_t cam_ripple_deviate(cam_turn_bin_t *bin);

/// Add order k of a turn. @param angle_q32  [turn / 2^32]
void cam_ripple_add(cam_ripple_t *r, uint32_t k, cam_complex_t angle_q32);

/// Complete a turn. The drift of the speed from the first to the last turn of a mean is subtracted.
/// @param n_turns    turns in a mean
/// @param least_q32  [turn / 2^32] an order up to this size counts as 0
/// @param speed_q36  result of cam_ripple_deviate()
/// @return whether there is a new mean
bool cam_ripple_close(cam_ripple_t *r, uint32_t n_turns, int32_t least_q32, int32_t speed_q36);

/// Discard the turns in the sum.
void cam_ripple_drop(cam_ripple_t *r);

/// @return [turn / 2^32] order k of the mean
cam_complex_t cam_ripple_order(const cam_ripple_t *r, uint32_t k);

/// @return [turn / 2^23] sum of the orders' sizes; beyond cam_ripple_most all are scaled down to it
///         before they act
uint32_t cam_ripple_sum(const cam_ripple_t *r);

#endif
