// SPDX-License-Identifier: Apache-2.0
/// cam_jog: axes that are moved by hand: jog, step and homing, the plan of the state manual.
///
/// One axis follows the order of the configuration (cam_jog_order.h), all others brake and stand.
/// An order that is over, stopped or too old brakes its axis within the axis's gentle acceleration.
/// The age is judged here, by the tick, so that an axis stops even if the slow side hangs,
/// MATHS.md (171).
///
/// Homing, MATHS.md (172):
///
///     here                                                  the place where the axis stands
///     search --switch--> release --no switch--> done        where it left the switch, or
///                                --> index --index--> done  where the first index lay behind that
///
/// Who stands on the switch begins with release. A phase that finds nothing within the travel of
/// the order ends the order; the axis is then not homed. U, whose travel is its stroke, calls its
/// place the end of the stroke when the search begins, and its home by its number at the end.
#ifndef CAM_JOG_H
#define CAM_JOG_H

#include "cam_config.h"    // cam_play_config_t
#include "cam_jog_order.h" // cam_jog_t
#include "cam_record.h"    // cam_tick_record_t, cam_motion_t
#include <stdint.h>        // int32_t, uint32_t

/// One plan of the state manual; it ends the state when a disable was requested and all axes rest.
/// @param r  record of the tick
/// @param m  increments up to now, replaced by those from the next tick on
/// @return   [nm] by which U's number rises at the place where it is, before the next tick; 0: none
/// Context: ISR; constant time in each phase.
int32_t cam_jog_isr(cam_jog_t *h, const cam_play_config_t *cfg, const cam_tick_record_t *r,
                    cam_motion_t *m);

/// One plan of any other state: an order that comes in it is never begun, and homes are forgotten
/// while the drives are not ready. Context: ISR, constant time.
void cam_jog_idle_isr(cam_jog_t *h, const cam_play_config_t *cfg, const cam_tick_record_t *r);

#endif
