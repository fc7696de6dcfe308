// SPDX-License-Identifier: Apache-2.0
/// cam_round: the order of the tasks of cam_plan.h, and how far ahead their ways end.
///
/// A round takes every task once. Where the spindle is modulated those of the speed ratio come
/// twice; where the tool swings a pass of the swing's tasks follows every two others, every four
/// on a modulated spindle:
///
///     uniform 21 ticks    modulated 43    swung 95    swung and modulated 117
///
/// Context: slow side.
#ifndef CAM_ROUND_H
#define CAM_ROUND_H

#include "cam_play.h" // cam_play_config_t
#include <stdbool.h>  // bool

/// Fill in all that depends on the round. Lead, lag and who leads Z are known.
/// @param is_modulated  the table has a speed channel
/// @param is_swung      the table swings the tool, and there is an axis for it
void cam_round_build(cam_play_config_t *c, bool is_modulated, bool is_swung);

#endif
