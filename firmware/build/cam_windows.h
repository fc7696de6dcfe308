// SPDX-License-Identifier: Apache-2.0
/// cam_windows: the windows of the position switches, of the parameters switch_1_.. to switch_8_..
///
/// The window of an output goes from switch_N_on_udeg in the sense in which the drawing's angle
/// rises to switch_N_off_udeg, and again switch_N_per_turn times per turn, whichever sense the
/// table cuts in. A window that fills its share of the turn is on all round; where both ends are
/// the same, it is empty. A hysteresis of more than a quarter of the window counts as that quarter.
/// Source: MATHS.md (180) .. (182). Context: slow side.
#ifndef CAM_WINDOWS_H
#define CAM_WINDOWS_H

#include "cam_config.h" // cam_switches_config_t
#include "cam_param.h"  // cam_params_t
#include <stdint.h>     // int32_t, uint32_t

/// @param sense  1, or -1 where the interrupt's angle is the negative of the drawing's
/// @return       windows of all outputs up to the last that is in use
cam_switches_config_t cam_windows_build(const cam_params_t *params, int32_t sense,
                                        uint32_t tick_hz);

#endif
