// SPDX-License-Identifier: Apache-2.0
/// cam_machine_jog: commands of the state manual, homes, datum and tools.
///
///     manual -> jog, jog, ..; step; home; zero -> disable
///
/// The spindle stands, and the axes hold until one is ordered to move: one at a time (cam_jog.h).
/// Every order holds for cam_jog_patience_ms. A jog goes on by being repeated, a step and a homing
/// by cam_machine_jog_alive(); without that the interrupt brakes the axis. Where a command is
/// refused for a limit, its verdict has the limit. Context: slow side, one caller.
#ifndef CAM_MACHINE_JOG_H
#define CAM_MACHINE_JOG_H

#include "cam_machine.h" // cam_machine_t
#include <stdbool.h>     // bool
#include <stdint.h>      // int32_t

enum { cam_jog_patience_ms = 250 };

/// A verdict with a number for people.
typedef struct {
    cam_err_t err;
    int32_t value; ///< of the command as accepted, or the limit for which it was refused
} cam_jog_verdict_t;

/// Enable the drives for hands: off -> manual. No table is needed.
/// @return cam_ok, cam_err_state, _busy, _estop, _drive, _bus, _u_place, _acknowledge,
///         _acknowledge_none
CAM_MUST_USE cam_err_t cam_machine_manual(cam_machine_t *m);

/// Move an axis until the order grows old, or to the limit of its travel.
/// @param um_per_s  [um/s] signed; 0 brakes
/// @return          cam_ok, cam_err_state, _busy, _hand_axis, _hand_moves while it is homed or
///                  makes a step; _hand_speed with the limit [um/s]
cam_jog_verdict_t cam_machine_jog(cam_machine_t *m, hal_axis_t axis, int32_t um_per_s);

/// Move an axis by a distance, at the speed of jogs.
/// @param nm  [nm] signed
/// @return    cam_ok, cam_err_state, _busy, _hand_axis, _hand_moves; _travel with the limit [nm] in
///            the machine's numbers
cam_jog_verdict_t cam_machine_step(cam_machine_t *m, hal_axis_t axis, int32_t nm);

/// Find the home of an axis, as its parameters say.
/// @return cam_ok, cam_err_state, _busy, _hand_axis, _hand_moves, _home_none
CAM_MUST_USE cam_err_t cam_machine_home_axis(cam_machine_t *m, hal_axis_t axis);

/// Say where the tool is: the datum follows. Nothing moves. In off, manual and ready.
/// @param axis  X or Z
/// @param nm    [nm] diameter that the tip touches with U where it is; height
/// @return      cam_ok with the datum [nm]; cam_err_hand_axis, _hand_moves, _not_homed, _busy,
///              _param_state; _param_range with the datum in force
cam_jog_verdict_t cam_machine_zero(cam_machine_t *m, hal_axis_t axis, int32_t nm);

/// Brake what is moved by hand. @return cam_ok, cam_err_busy
CAM_MUST_USE cam_err_t cam_machine_jog_stop(cam_machine_t *m);

/// A sign of life of whoever gave the order that is carried out.
void cam_machine_jog_alive(cam_machine_t *m);

/// @return [nm] where an axis is, in the machine's numbers
int32_t cam_machine_position_nm(const cam_machine_t *m, hal_axis_t axis);

/// Judge whether the axes may follow the table, which there is: homed where homing_required is set,
/// and the part within the travel of X and Z where that is known.
/// @return cam_ok, cam_err_busy until a home that was found is in force, cam_err_not_homed,
///         cam_err_travel
CAM_MUST_USE cam_err_t cam_machine_check_positions(const cam_machine_t *m,
                                                   const cam_status_t *status);

/// @return whether X can reach all that the table asks of it in every pass, as far as its travel is
///         known: the work, its clearance, and the place of a rehearsal
/// @param x_trim_nm  [nm] the operator's trim
bool cam_machine_is_x_in_travel(const cam_machine_t *m, const cam_status_t *status,
                                int32_t x_trim_nm);

/// The part of cam_machine_poll() that takes homes over which were found.
void cam_machine_jog_poll(cam_machine_t *m);

#endif
