// SPDX-License-Identifier: Apache-2.0
/// cam_machine_inner: how the files cam_machine_*.c hand requests and configurations over.
///
/// Both ways have room for one: until the interrupt has taken it, the next is refused with
/// cam_err_busy. Nobody outside of this folder includes this header.
/// Context: slow side, one caller.
#ifndef CAM_MACHINE_INNER_H
#define CAM_MACHINE_INNER_H

#include "cam_machine.h" // cam_machine_t
#include <stdbool.h>     // bool
#include <stdint.h>      // uint32_t

/// @return whether the interrupt has carried out the last request
bool cam_machine_is_carried_out(const cam_machine_t *m, const cam_status_t *status);

/// @return whether the state in *status may be about to change: the last request is not carried
///         out, or the next step of an excitation is still to come
bool cam_machine_is_pending(const cam_machine_t *m, const cam_status_t *status);

/// Request what the caller knows to be in order: the last request is carried out.
void cam_machine_request(cam_machine_t *m, cam_request_t request);

/// Post a request to the interrupt, which takes it in the next tick.
/// @return cam_ok, or cam_err_busy while something is pending
CAM_MUST_USE cam_err_t cam_machine_post(cam_machine_t *m, const cam_status_t *status,
                                        cam_request_t request);

/// Post a request if the state allows it.
/// @return as cam_machine_post(), or cam_err_state
CAM_MUST_USE cam_err_t cam_machine_post_if(cam_machine_t *m, const cam_status_t *status,
                                           bool is_allowed, cam_request_t request);

/// Check the inputs, and that U stands inside of its stroke: set-points stay in the stroke, so that
/// from outside U would jump to the edge when it is enabled.
/// @return cam_ok, cam_err_estop, _drive, _bus, _u_place
CAM_MUST_USE cam_err_t cam_machine_check_drives(const cam_params_t *params,
                                                const cam_status_t *status);

/// @return cam_ok when somebody at the machine has said that it may move, or this port needs nobody
///         to; else cam_err_acknowledge, or cam_err_acknowledge_none when it has no button
CAM_MUST_USE cam_err_t cam_machine_check_acknowledge(const cam_machine_t *m,
                                                     const cam_status_t *status);

/// Carry out what follows when the commander is lost: the cut ends as by stop, axes that are moved
/// by hand brake. Context: cam_machine_poll().
void cam_machine_rights_poll(cam_machine_t *m, const cam_status_t *status);

/// @return what the configuration demands of the button at the machine
cam_acknowledge_config_t cam_machine_acknowledge_config(const cam_machine_t *m);

/// Judge the speeds that start would use with these parameters and this table. What is infeasible
/// is kept with its numbers, for cam_machine_refusal().
/// @return cam_ok or why not (cam_feasible.h)
CAM_MUST_USE cam_err_t cam_machine_judge(cam_machine_t *m, const cam_params_t *params,
                                         const cam_table_t *table);

/// @return the parameters of a port that keeps none: the defaults, learning where U is measured
cam_params_t cam_machine_defaults(uint32_t tick_hz);

/// Hand over the parameters that the port keeps, if they are whole and fit the tick.
/// Context: before the tick starts.
/// @return false when nothing was handed over; m->kept tells why
bool cam_machine_load_params(cam_machine_t *m);

/// Hand parameters and table to the interrupt as one configuration, with what has been learned.
/// Nothing changes on error.
/// @param table  NULL: none
/// @param pass   of the table that start cuts with it
/// @return       cam_ok, cam_err_busy, or why they do not fit together (cam_build.h)
CAM_MUST_USE cam_err_t cam_machine_hand_over(cam_machine_t *m, const cam_params_t *params,
                                             const cam_table_t *table, uint32_t pass);

#endif
