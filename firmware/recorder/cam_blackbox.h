// SPDX-License-Identifier: Apache-2.0
/// cam_blackbox: a recording that the controller always runs and that a fault triggers.
///
/// While the recorder (cam_scope.h) is free, its ring holds the signals CAM_BLACKBOX_SIGNALS of the
/// last cam_blackbox_before_ms. A fault triggers it; the recording ends cam_blackbox_after_ms later
/// and stays, with a head before its rows so that the port can keep it over a restart
/// (hal_scope_keep()). Rows are as many ticks apart as the memory requires. Context: slow side.
#ifndef CAM_BLACKBOX_H
#define CAM_BLACKBOX_H

#include "cam_err.h"   // CAM_MUST_USE
#include "cam_scope.h" // cam_scope_t
#include <stdbool.h>   // bool
#include <stdint.h>    // uint32_t

/// [ms] recorded before and after the fault.
enum { cam_blackbox_before_ms = 500, cam_blackbox_after_ms = 20 };

/// Recorded signals; 375 kB at 20 kHz.
#define CAM_BLACKBOX_SIGNALS                                                                       \
    (UINT32_C(1) << cam_scope_state | UINT32_C(1) << cam_scope_u_due_q6 |                          \
     UINT32_C(1) << cam_scope_u_command_nm | UINT32_C(1) << cam_scope_u_actual_nm |                \
     UINT32_C(1) << cam_scope_angle_q32 | UINT32_C(1) << cam_scope_speed_q32 |                     \
     UINT32_C(1) << cam_scope_z_nm | UINT32_C(1) << cam_scope_faults |                             \
     UINT32_C(1) << cam_scope_inputs)

/// Start the black box. @return cam_ok, cam_err_scope_memory
CAM_MUST_USE cam_err_t cam_blackbox_begin(cam_scope_t *s, uint32_t tick);

/// @return whether it holds the recording of a fault that nobody has released
static inline bool cam_blackbox_is_unread(const cam_scope_t *s)
{
    return s->use == cam_scope_box && s->phase == cam_scope_done;
}

/// Write the head of a finished recording and have the port keep it.
void cam_blackbox_keep(const cam_scope_t *s);

/// Restore a recording that the port has kept over a restart; one whose head does not match the
/// memory or the tick rate is ignored.
/// @param n_kept  [words] at the start of the memory
/// @return        whether a recording was restored
bool cam_blackbox_restore(cam_scope_t *s, uint32_t n_kept);

#endif
