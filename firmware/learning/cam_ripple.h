// SPDX-License-Identifier: Apache-2.0
/// cam_ripple: how the angle of the spindle deviates from uniform rotation, learned per angle.
///
/// Every turn tells it directly: measured angle minus the angle of a uniform rotation that takes as
/// long for the turn, by the ticks that fell into each bin. The mean over several turns is what the
/// encoder shows of the ripple; its eccentricity is in it, and is a parameter of its own. There is
/// no loop in it. Source: MATHS.md (146), (147). Context: slow side.
#ifndef CAM_RIPPLE_H
#define CAM_RIPPLE_H

#include "cam_complex.h"   // cam_complex_t
#include "cam_harmonics.h" // cam_harmonics_most
#include "cam_turn_bins.h" // cam_turn_bin_t
#include <stdbool.h>       // bool
#include <stdint.h>        // int16_t, int32_t, uint32_t

/// [turn / 2^32] in a unit of the interrupt's tables, 2^-23 turn: 2^9.
enum { cam_ripple_down = 9 };

/// [turn / 2^23] An order of the mean is no larger.
enum { cam_ripple_most = INT16_MAX / 16 };

/// State; zero-initialised has learned nothing.
typedef struct {
    cam_complex_t sum[cam_harmonics_most]; ///< [turn / 2^32] of orders 1 .. 16, over n turns
    struct {
        int16_t re;
        int16_t im;
    } mean[cam_harmonics_most]; ///< [turn / 2^23] what the encoder shows, in force
    int32_t first_q36;          ///< [turn / 2^36 per tick] speed of their first
    int32_t last_q36;           ///< ... and of their last turn
    uint32_t n;                 ///< turns in the sum
    uint32_t n_mean;            ///< turns that the mean was made of, 0: none
    int32_t speed_q32;          ///< [turn / 2^32 per tick] of the mean
    cam_complex_t scale;        ///< [turn / 2^32] what of order 1 does not fall with
                                ///< the square of the speed
} cam_ripple_t;

/// Turn the sums of angle of a whole turn into the deviation from uniform rotation, in place.
/// @param bin  128 bins of a turn, each with its sum of angle_q24 and n; angle becomes the
///             deviation in turn / 2^32, less a constant
/// @return     [turn / 2^36 per tick] mean speed of the turn; 0 when a bin is empty or the
/// deviation
///             does not fit: the turn must be forgotten
int32_t cam_ripple_deviate(cam_turn_bin_t *bin);

/// Add order k of a turn. @param angle_q32  [turn / 2^32]
void cam_ripple_add(cam_ripple_t *r, uint32_t k, cam_complex_t angle_q32);

/// A turn is complete. What the speed drifted from the first to the last turn of a mean is taken
/// off its harmonics.
/// @param n_turns    of which a mean is made
/// @param least_q32  [turn / 2^32] an order that is not larger counts as nothing
/// @param speed_q36  what cam_ripple_deviate() returned
/// @return whether there is a new mean
bool cam_ripple_close(cam_ripple_t *r, uint32_t n_turns, int32_t least_q32, int32_t speed_q36);

/// Forget the turns of which no mean was made.
void cam_ripple_drop(cam_ripple_t *r);

/// @return [turn / 2^32] order k of the mean
cam_complex_t cam_ripple_order(const cam_ripple_t *r, uint32_t k);

#endif
