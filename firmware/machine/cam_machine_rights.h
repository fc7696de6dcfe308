// SPDX-License-Identifier: Apache-2.0
/// cam_machine_rights: what the rights of commanders (cam_rights.h) do to the machine, and what is
/// told of them and of the button at it.
///
/// Nothing is in the work, or moved by hand, without a commander: when command is lost or given up,
/// the cut ends as by cam_machine_stop(), and axes that are moved by hand brake. In the other
/// states nothing is ended: the drives stay as they are. All functions: slow side, one caller.
#ifndef CAM_MACHINE_RIGHTS_H
#define CAM_MACHINE_RIGHTS_H

#include "cam_machine.h" // cam_machine_t
#include <stdbool.h>     // bool
#include <stdint.h>      // uint32_t, uint8_t

/// What is told of the button at the machine. The number is part of the CAN protocol.
typedef enum {
    cam_button_needed, ///< nothing is enabled before it was pressed
    cam_button_given,  ///< it was pressed
    cam_button_none,   ///< the port has none, and nothing is enabled
    cam_button_waived, ///< the port's builder has waived it
} cam_button_t;

/// What is told of all rights.
typedef struct {
    uint32_t commander; ///< its sender number, 0: nobody
    uint32_t n_take_overs, n_losses;
    cam_level_t level;
    uint32_t level_left_s; ///< [s] until it is locked again, 0: it is
    cam_button_t button;
    uint32_t button_left_s; ///< [s] in which enable must come, 0: that does not end
} cam_rights_status_t;

/// Take command (cam_rights_take()). @return cam_ok, cam_err_not_commander, cam_err_frame
CAM_MUST_USE cam_err_t cam_machine_take_command(cam_machine_t *m, uint8_t sender, bool is_over);

/// Give command up; what moves by it stops.
void cam_machine_release_command(cam_machine_t *m);

/// @return what is told of rights and button
cam_rights_status_t cam_machine_rights(const cam_machine_t *m, const cam_status_t *status);

#endif
