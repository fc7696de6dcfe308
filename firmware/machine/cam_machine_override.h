// SPDX-License-Identifier: Apache-2.0
/// cam_machine_override: feed hold and part counter.
///
/// Feed override, spindle override and X trim are parameters (feed_override_ppm,
/// spindle_override_ppm, x_trim_nm). A hold stops Z on a whole turn while U and X continue; the
/// state is then holding. The hold ends with the cut. Context: slow side.
#ifndef CAM_MACHINE_OVERRIDE_H
#define CAM_MACHINE_OVERRIDE_H

#include "cam_err.h"     // cam_err_t
#include "cam_machine.h" // cam_machine_t
#include <stdint.h>      // int32_t, uint32_t

/// Hold the feed: Z stops within its ramp on a whole turn, a ring-helix where the next ring begins.
/// In rehearsing and engaging, the hold takes effect where the feed would begin. Within the ramp at
/// the end of the part, the feed continues to the end.
/// @return cam_ok, cam_err_state, cam_err_override_measured
CAM_MUST_USE cam_err_t cam_machine_hold(cam_machine_t *m);

/// Resume the feed on a whole turn.
/// @return cam_ok, or cam_err_state when nothing is held
CAM_MUST_USE cam_err_t cam_machine_resume(cam_machine_t *m);

/// Set the part counter.
/// @return cam_ok, or cam_err_param_range when below 0
CAM_MUST_USE cam_err_t cam_machine_set_parts(cam_machine_t *m, int32_t n);

/// Hand a hold over to the interrupt, and clear it after the cut. Part of cam_machine_poll().
void cam_machine_override_poll(cam_machine_t *m, const cam_status_t *status);

#endif
