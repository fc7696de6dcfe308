// SPDX-License-Identifier: Apache-2.0
/// cam_wave: check of an excitation of U against U's limits (cam_excite.h).
///
/// A periodic wave w is played with a gain g <= 1 of at most g1 per tick and g2 per tick^2. The
/// product stays within |w|, its speed within max |dw| + g1 max |w|, its acceleration within
/// max |d2w| + 2 g1 max |dw| + g2 max |w|, with the differences across the wrap. A wave of force
/// stays within the force limit, whatever the gain.
/// Context: slow side.
#ifndef CAM_WAVE_H
#define CAM_WAVE_H

#include "cam_config.h"       // cam_config_t
#include "cam_err.h"          // cam_err_t
#include "cam_move_profile.h" // cam_motion_limits_t
#include <stdint.h>           // int32_t, int64_t, uint32_t

enum {
    cam_wave_least = 16,           ///< [ticks] shortest period, shortest fade
    cam_wave_longest_fade = 65535, ///< [ticks]
    cam_wave_longest_s = 60,       ///< [s] fade and periods together
};

/// Range, speed and acceleration of a wave; of a wave of force mN take the place of nm.
typedef struct {
    int64_t low_nm, high_nm; ///< [nm] least and largest of the samples and 0
    int64_t step_nm;         ///< [nm per tick] largest difference of neighbours
    int64_t bend_nm;         ///< [nm per tick^2] largest second difference
} cam_wave_range_t;

/// @param wave_nm  [nm], or [mN] of force
/// @param n        samples, at least 2
cam_wave_range_t cam_wave_range(const int32_t *wave_nm, uint32_t n);

/// @param fade_ticks  [ticks] cam_wave_least .. cam_wave_longest_fade
/// @return            limits of a gain that rises from 0 to 1 in this time, or in up to a quarter
///                    less for a long fade; cam_wave_fall_ticks() counts the ticks
cam_motion_limits_t cam_wave_fade(uint32_t fade_ticks);

/// @return [ticks] in which the gain falls from 1 to 0, without the last tick, at rest
/// Context: takes one step of cam_move_profile.h per tick.
uint32_t cam_wave_fall_ticks(const cam_motion_limits_t *fade);

/// @return [nm] largest distance of a sample from 0
int64_t cam_wave_peak_nm(const cam_wave_range_t *range);

/// Check a wave of force, and that the position of U about which it plays is in the stroke.
/// @param range     [mN]
/// @param place_nm  [nm]
/// @return          cam_ok; cam_err_wave_force with the largest force [mN], cam_err_wave_stroke
cam_verdict_t cam_wave_judge_force(const cam_wave_range_t *range, int32_t place_nm,
                                   const cam_config_t *cfg);

/// Check stroke, speed and acceleration of U.
/// @param place_nm  [nm] U's mean position
/// @param cfg       configuration in force
/// @return          cam_ok, or a demand above its limit: cam_err_wave_stroke with the position [nm]
///                  farthest from 0, _wave_speed [um/s], _wave_acceleration [mm/s2]
cam_verdict_t cam_wave_judge(const cam_wave_range_t *range, const cam_motion_limits_t *fade,
                             int32_t place_nm, const cam_config_t *cfg, uint32_t tick_hz);

#endif
