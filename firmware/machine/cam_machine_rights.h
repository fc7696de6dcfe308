// SPDX-License-Identifier: Apache-2.0
/// cam_machine_rights: effect of the commanders' rights (cam_rights.h) on the machine; status of
/// the rights and of the acknowledge button.
///
/// Cutting and jogging need a commander: when command is lost or released, the machine stops as by
/// cam_machine_stop(). The other states continue. All functions: slow side, one caller.
#ifndef CAM_MACHINE_RIGHTS_H
#define CAM_MACHINE_RIGHTS_H

#include "cam_machine.h" // cam_machine_t
#include <stdbool.h>     // bool
#include <stdint.h>      // uint32_t, uint8_t

/// State of the acknowledge button. The numbers are part of the CAN protocol.
typedef enum {
    cam_button_needed, ///< must be pressed before enable
    cam_button_given,  ///< pressed
    cam_button_none,   ///< the port has none, so enable is refused
    cam_button_waived, ///< waived by the port's builder
} cam_button_t;

/// Status of the rights and of the button.
typedef struct {
    uint32_t commander; ///< sender number; 0: none
    uint32_t n_take_overs, n_losses;
    cam_level_t level;
    uint32_t level_left_s; ///< [s] until locked again; 0: locked
    cam_button_t button;
    uint32_t button_left_s; ///< [s] left for enable; 0: no time limit
} cam_rights_status_t;

/// Take command (cam_rights_take()). @return cam_ok, cam_err_not_commander, cam_err_frame
CAM_MUST_USE cam_err_t cam_machine_take_command(cam_machine_t *m, uint8_t sender, bool is_over);

/// Release command and stop the motion.
void cam_machine_release_command(cam_machine_t *m);

cam_rights_status_t cam_machine_rights(const cam_machine_t *m, const cam_status_t *status);

#endif
