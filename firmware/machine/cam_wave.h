// SPDX-License-Identifier: Apache-2.0
/// cam_wave: a wave for U, judged before it is played (cam_excite.h).
///
/// A wave w is played in a circle, times a gain g of at most 1 that moves at most by g1 per tick
/// and bends by at most g2 per tick^2. The product stays within |w|, moves by at most
/// max |dw| + g1 max |w|, and bends by at most max |d2w| + 2 g1 max |dw| + g2 max |w|, differences
/// across the wrap included. These bounds are compared with the limits of U.
/// Context: slow side.
#ifndef CAM_WAVE_H
#define CAM_WAVE_H

#include "cam_config.h"       // cam_config_t
#include "cam_err.h"          // cam_err_t
#include "cam_move_profile.h" // cam_motion_limits_t
#include <stdint.h>           // int32_t, int64_t, uint32_t

enum {
    cam_wave_least = 16,           ///< [ticks] shortest period, and shortest fade
    cam_wave_longest_fade = 65535, ///< [ticks]
    cam_wave_longest_s = 60,       ///< [s] fade and periods together
};

/// What a wave demands of U.
typedef struct {
    int64_t low_nm, high_nm; ///< [nm] of its samples, 0 included
    int64_t step_nm;         ///< [nm per tick] largest difference of neighbours
    int64_t bend_nm;         ///< [nm per tick^2] largest second difference
} cam_wave_range_t;

/// A verdict; `value` is what the wave would demand where it is refused.
typedef struct {
    cam_err_t err;
    int32_t value; ///< wave_stroke [nm]: place farthest from 0; wave_speed [um/s];
                   ///< wave_acceleration [mm/s2]; wave_length [ticks]: the longest
} cam_wave_verdict_t;

/// @param n  samples, at least 2
cam_wave_range_t cam_wave_range(const int32_t *wave_nm, uint32_t n);

/// @param fade_ticks  [ticks] cam_wave_least .. cam_wave_longest_fade
/// @return            limits of a gain that rises from 0 to 1 in that many ticks, up to a quarter
///                    less where they are many; cam_wave_fall_ticks() tells
cam_motion_limits_t cam_wave_fade(uint32_t fade_ticks);

/// @return [ticks] in which the gain falls from 1 to 0, the last one before it rests there
/// Context: lasts as long as as many steps of cam_move_profile.h.
uint32_t cam_wave_fall_ticks(const cam_motion_limits_t *fade);

/// Compare with the stroke, the speed and the acceleration of U.
/// @param place_nm  [nm] about which it is played
/// @param cfg       configuration in force
cam_wave_verdict_t cam_wave_judge(const cam_wave_range_t *range, const cam_motion_limits_t *fade,
                                  int32_t place_nm, const cam_config_t *cfg, uint32_t tick_hz);

#endif
