// SPDX-License-Identifier: Apache-2.0
/// cam_windows: windows of the position switches, from the parameters switch_1_.. to switch_8_..
///
/// The window of an output extends from switch_N_on_udeg to switch_N_off_udeg in the sense in which
/// the drawing's angle rises, whatever the sense of cutting, and repeats switch_N_per_turn times
/// per turn. A window that fills its share of the turn is always on; one with equal ends is empty.
/// The hysteresis is limited to a quarter of the window.
/// Source: MATHS.md (180) .. (182). Context: slow side.
#ifndef CAM_WINDOWS_H
#define CAM_WINDOWS_H

#include "cam_config.h" // cam_switches_config_t
#include "cam_param.h"  // cam_params_t
#include <stdint.h>     // int32_t, uint32_t

/// @param sense  1, or -1 where the interrupt's angle is the negative of the drawing's
/// @return       windows of all outputs up to the last one in use
cam_switches_config_t cam_windows_build(const cam_params_t *params, int32_t sense,
                                        uint32_t tick_hz);

#endif
