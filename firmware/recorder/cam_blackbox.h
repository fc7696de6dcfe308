// SPDX-License-Identifier: Apache-2.0
/// cam_blackbox: the black box, a recording that the controller makes of its own before every
/// fault.
///
/// While nobody else records, the recorder (cam_scope.h) keeps the last cam_blackbox_before_ms of
/// the signals CAM_BLACKBOX_SIGNALS in its ring. A fault is the trigger; cam_blackbox_after_ms
/// later the box is done and stays, with a head in front of its rows that the port may keep beyond
/// a restart (hal_scope_keep()). Where the memory is too small for every tick, rows are so many
/// ticks apart that the whole time fits. Context: slow side.
#ifndef CAM_BLACKBOX_H
#define CAM_BLACKBOX_H

#include "cam_err.h"   // CAM_MUST_USE
#include "cam_scope.h" // cam_scope_t
#include <stdbool.h>   // bool
#include <stdint.h>    // uint32_t

/// [ms] that the box tells of before and behind the fault.
enum { cam_blackbox_before_ms = 500, cam_blackbox_after_ms = 20 };

/// What the box holds; at 20 kHz 375 kB.
#define CAM_BLACKBOX_SIGNALS                                                                       \
    (UINT32_C(1) << cam_scope_state | UINT32_C(1) << cam_scope_u_due_q6 |                          \
     UINT32_C(1) << cam_scope_u_command_nm | UINT32_C(1) << cam_scope_u_actual_nm |                \
     UINT32_C(1) << cam_scope_angle_q32 | UINT32_C(1) << cam_scope_speed_q32 |                     \
     UINT32_C(1) << cam_scope_z_nm | UINT32_C(1) << cam_scope_faults |                             \
     UINT32_C(1) << cam_scope_inputs)

/// Begin to record. @return cam_ok, cam_err_scope_memory
CAM_MUST_USE cam_err_t cam_blackbox_begin(cam_scope_t *s, uint32_t tick);

/// @return whether the box of a fault is there, and nobody has released it
static inline bool cam_blackbox_is_unread(const cam_scope_t *s)
{
    return s->use == cam_scope_box && s->phase == cam_scope_done;
}

/// Write the head of a box that is done, and hand it to the port.
void cam_blackbox_keep(const cam_scope_t *s);

/// Take up a box that the port has kept beyond a restart. One whose head does not fit the memory or
/// the rate of the ticks is passed over.
/// @param n_kept  [words] at the begin of the memory
/// @return        whether one is there
bool cam_blackbox_restore(cam_scope_t *s, uint32_t n_kept);

#endif
