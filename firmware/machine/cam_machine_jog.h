// SPDX-License-Identifier: Apache-2.0
/// cam_machine_jog: commands of the state manual: jog, step, home, zero.
///
///     manual -> jog, jog, ..; step; home; zero -> disable
///
/// The spindle stands still, and one axis at a time moves by order (cam_jog.h). An order expires
/// after cam_jog_patience_ms, and the interrupt brakes the axis. A repeated jog command renews a
/// jog, cam_machine_keep_alive() a step or a homing. Context: slow side, one caller.
#ifndef CAM_MACHINE_JOG_H
#define CAM_MACHINE_JOG_H

#include "cam_err.h"     // cam_verdict_t
#include "cam_machine.h" // cam_machine_t
#include <stdbool.h>     // bool
#include <stdint.h>      // int32_t

enum { cam_jog_patience_ms = 250 };

/// Enable the drives: off -> manual. No table is needed.
/// @return cam_ok, cam_err_state, _busy, _estop, _drive, _bus, _servo_none, _u_place, _acknowledge,
///         _acknowledge_none
CAM_MUST_USE cam_err_t cam_machine_manual(cam_machine_t *m);

/// Move an axis until the order expires, or to the limit of its travel.
/// @param um_per_s  [um/s] signed; 0 brakes
/// @return          cam_ok, cam_err_state, _busy, _hand_axis, _hand_moves during a step or homing;
///                  _hand_speed with the limit [um/s]
cam_verdict_t cam_machine_jog(cam_machine_t *m, hal_axis_t axis, int32_t um_per_s);

/// Move an axis by a distance, at its highest jog speed.
/// @param nm  [nm] signed
/// @return    cam_ok, cam_err_state, _busy, _hand_axis, _hand_moves; _travel with the limit [nm] in
///            machine coordinates
cam_verdict_t cam_machine_step(cam_machine_t *m, hal_axis_t axis, int32_t nm);

/// Home an axis by the method in its parameters.
/// @return cam_ok, cam_err_state, _busy, _hand_axis, _hand_moves, _home_none
CAM_MUST_USE cam_err_t cam_machine_home_axis(cam_machine_t *m, hal_axis_t axis);

/// Set the datum from the tool's position. Nothing moves. In off, manual and ready.
/// @param axis  X or Z
/// @param nm    [nm] X: diameter that the tip touches at U's present position; Z: height
/// @return      cam_ok with the datum [nm]; cam_err_hand_axis, _hand_moves, _not_homed, _busy,
///              _param_state; _param_range with the datum in force
cam_verdict_t cam_machine_zero(cam_machine_t *m, hal_axis_t axis, int32_t nm);

/// Brake the moving axis. @return cam_ok, cam_err_busy
CAM_MUST_USE cam_err_t cam_machine_jog_stop(cam_machine_t *m);

/// @return [nm] the position of an axis, in machine coordinates
int32_t cam_machine_position_nm(const cam_machine_t *m, hal_axis_t axis);

/// Check whether the axes may follow the loaded table: homed where homing_required is set, and the
/// part within the known travel of X and Z.
/// @return cam_ok, cam_err_busy until a new home is in force, cam_err_not_homed, cam_err_travel
CAM_MUST_USE cam_err_t cam_machine_check_positions(const cam_machine_t *m,
                                                   const cam_status_t *status);

/// @return whether all X positions of every pass are within X's known travel: the cut, the
///         clearance and the rehearsal
/// @param x_trim_nm  [nm] the operator's trim
bool cam_machine_is_x_in_travel(const cam_machine_t *m, const cam_status_t *status,
                                int32_t x_trim_nm);

/// Part of cam_machine_poll(): apply new homes.
void cam_machine_jog_poll(cam_machine_t *m);

#endif
