// SPDX-License-Identifier: Apache-2.0
/// cam_machine_override: what the operator does while a part is cut, besides parameters.
///
/// Overrides of feed and spindle and the trim of X are parameters (feed_override_ppm,
/// spindle_override_ppm, x_trim_nm); cam_machine_set_param() takes them in the work, too. A hold
/// brings Z to rest on a whole turn while U and X go on; the state is then holding. It is forgotten
/// when the cut ends. Context: slow side.
#ifndef CAM_MACHINE_OVERRIDE_H
#define CAM_MACHINE_OVERRIDE_H

#include "cam_err.h"     // cam_err_t
#include "cam_machine.h" // cam_machine_t
#include <stdint.h>      // int32_t, uint32_t

/// Hold the feed: Z rests within its ramp on a whole turn, a ring-helix where the next ring begins.
/// In rehearsing and engaging the cut is held where its feed would begin. A feed that is within the
/// ramp to the end of the part goes on to that end.
/// @return cam_ok, cam_err_state, cam_err_override_measured
CAM_MUST_USE cam_err_t cam_machine_hold(cam_machine_t *m);

/// Let the feed go on from a whole turn.
/// @return cam_ok, or cam_err_state when nothing is held
CAM_MUST_USE cam_err_t cam_machine_resume(cam_machine_t *m);

/// Set the number of parts that were cut.
/// @return cam_ok, or cam_err_param_range when below 0
CAM_MUST_USE cam_err_t cam_machine_set_parts(cam_machine_t *m, int32_t n);

/// Hand a hold over, and forget it behind the cut. A part of cam_machine_poll().
void cam_machine_override_poll(cam_machine_t *m, const cam_status_t *status);

#endif
