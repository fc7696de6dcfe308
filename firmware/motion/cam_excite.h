// SPDX-License-Identifier: Apache-2.0
/// cam_excite: plays a test wave on U to identify its drive, of positions or of forces.
///
/// In the state identifying U moves to a position and rests; then a wave from memory is added to
/// its set-point, times a gain that rises from 0 to 1 and falls to 0 again with limited speed and
/// acceleration (cam_move_profile.h). The wave has no feed-forward. After n_play ticks the gain
/// falls; when it rests at 0 the excitation is over. An earlier end makes the gain fall at once.
/// A wave of force is added to the force of U instead, and U's set-point rests. It ends without a
/// fall, from one tick to the next.
///
/// The slow side has checked the wave (cam_wave.h): at any gain the set-point stays within stroke,
/// speed and acceleration of U. Context: ISR, constant time.
#ifndef CAM_EXCITE_H
#define CAM_EXCITE_H

#include "cam_move_profile.h" // cam_axis_motion_t, cam_motion_limits_t
#include <stdbool.h>          // bool
#include <stdint.h>           // int32_t, uint32_t

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
