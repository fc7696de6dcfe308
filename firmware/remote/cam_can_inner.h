// SPDX-License-Identifier: Apache-2.0
/// cam_can_inner: commands of cam_can.c, private to this room. Context: slow side, main() only.
#ifndef CAM_CAN_INNER_H
#define CAM_CAN_INNER_H

#include "cam_can.h" // cam_can_t
#include "cam_err.h" // cam_err_t
#include "camturn.h" // struct camturn_command_t
#include <stdbool.h> // bool
#include <stdint.h>  // int32_t

/// Result of a command and the value of its answer.
typedef struct {
    cam_err_t err;
    int32_t value;
    bool is_deferred; ///< the answer follows the piece of a recording
    bool has_range;   ///< two more answers give the smallest and the largest value
    int32_t min, max;
} cam_outcome_t;

/// @return an outcome without a value
static inline cam_outcome_t cam_outcome(cam_err_t err)
{
    return (cam_outcome_t){.err = err};
}

/// @return whether the sender of a command may give it: cam_ok, cam_err_not_commander,
///         cam_err_locked or cam_err_lock_none
cam_err_t cam_can_admit(const cam_rights_t *rights, const struct camturn_command_t *m);

/// Execute a command that was admitted.
cam_outcome_t cam_can_carry_out(cam_can_t *r, const struct camturn_command_t *m);

/// @return an error with the number of bytes stored
cam_outcome_t cam_can_received(const cam_can_t *r, cam_err_t err);

/// Select the table and report it in a line of text, unless the error is temporary.
cam_err_t cam_can_select(cam_can_t *r);

#endif
