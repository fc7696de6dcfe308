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

/// Execute a command.
/// @param m  its parameter becomes that of the answer
cam_outcome_t cam_can_carry_out(cam_can_t *r, struct camturn_command_t *m);

/// @return an error with the number of bytes stored
cam_outcome_t cam_can_received(const cam_can_t *r, cam_err_t err);

/// Select the table and report it in a line of text, unless the error is temporary.
cam_err_t cam_can_select(cam_can_t *r);

#endif
