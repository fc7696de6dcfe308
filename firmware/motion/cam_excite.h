// SPDX-License-Identifier: Apache-2.0
/// cam_excite: U plays a wave by time, so that its drive can be identified.
///
/// In the state identifying U moves to a place and rests there, and then a wave from memory is
/// added to its set-point, times a gain that rises from 0 to 1 and falls to 0 again by a motion of
/// limited speed and acceleration (cam_move_profile.h). The wave has no feed-forward. The length is
/// bounded: after n_play ticks at the place the gain falls, and when it rests at 0 the excitation
/// is over. An end that comes earlier lets the gain fall from where it is.
///
/// The wave was checked on the slow side (cam_wave.h): with the gain at any place of its motion
/// the set-point stays within stroke, speed and acceleration of U.
/// Context: ISR.
#ifndef CAM_EXCITE_H
#define CAM_EXCITE_H

#include "cam_move_profile.h" // cam_axis_motion_t, cam_motion_limits_t
#include <stdbool.h>          // bool
#include <stdint.h>           // int32_t, uint32_t

enum { cam_excite_full_q30 = 1 << 30 }; ///< gain 1

/// What is played; n 0: nothing, and the request is ignored.
typedef struct {
    const int32_t *wave_nm;   ///< [nm] samples of a period, one per tick
    uint32_t n;               ///< [ticks] samples of the period
    uint32_t first;           ///< sample that is played first
    uint32_t n_play;          ///< [ticks] until the gain falls, its rise included
    cam_motion_limits_t fade; ///< [2^-30 per tick, per tick^2] of the gain
    int64_t place_q10;        ///< [nm / 1024] of U, about which it is played
} cam_excite_config_t;

/// State; zero-initialised is over.
typedef struct {
    uint32_t at;            ///< sample that is played next
    uint32_t n_left;        ///< [ticks] until the gain falls
    cam_axis_motion_t gain; ///< pos_q10 is [2^-30]
} cam_excite_t;

/// Begin with the gain 0.
void cam_excite_begin_isr(cam_excite_t *e, const cam_excite_config_t *cfg);

/// Let the gain fall from the next tick on.
void cam_excite_end_isr(cam_excite_t *e);

/// One tick, with U at rest at its place apart from the wave.
/// @param offset_q6  result, [nm / 64] to be added to the set-point of U
/// @return           true when the gain has come to rest at 0 behind the end
/// Constant time.
bool cam_excite_step_isr(cam_excite_t *e, const cam_excite_config_t *cfg, int32_t *offset_q6);

#endif
