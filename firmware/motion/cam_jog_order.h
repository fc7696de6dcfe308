// SPDX-License-Identifier: Apache-2.0
/// cam_jog_order: what hands order of an axis, and how far it has been carried out.
///
/// An order is a part of the configuration (cam_config.h), so that a replay has it as well. It
/// begins when its serial number is new, and holds until the tick that it carries: the slow side
/// writes a later one as long as its commander lives. Positions are those of the port.
#ifndef CAM_JOG_ORDER_H
#define CAM_JOG_ORDER_H

#include "cam_move_profile.h" // cam_motion_limits_t
#include "hal/hal.h"          // hal_axis_t
#include <stdbool.h>          // bool
#include <stdint.h>           // int32_t, int64_t, uint32_t

/// What is done by hand. The number is part of the CAN protocol.
typedef enum {
    cam_jog_rest,    ///< nothing: all axes brake and stand
    cam_jog_jog,     ///< the axis moves as long as the order holds
    cam_jog_step,    ///< ... by a distance
    cam_jog_here,    ///< homing: where the axis stands is its home
    cam_jog_search,  ///< homing: towards the switch
    cam_jog_release, ///< homing: back, off the switch
    cam_jog_index,   ///< homing: on to the index
    cam_jog_n_phases
} cam_jog_phase_t;

/// What came of the last order. The number is part of the CAN protocol.
typedef enum {
    cam_jog_never,      ///< there was none
    cam_jog_runs,       ///< it is being carried out
    cam_jog_done,       ///< the step is made, the home is found
    cam_jog_stopped,    ///< cut short by stop, disable or a fault
    cam_jog_silent,     ///< cut short because its commander went silent
    cam_jog_limit,      ///< the axis stands at the limit of its travel
    cam_jog_no_switch,  ///< no switch within the travel of the search
    cam_jog_no_release, ///< the switch stays active within that travel
    cam_jog_no_index,   ///< no index within that travel
    cam_jog_no_stroke,  ///< U's home was found so far out that U would stand outside its stroke
    cam_jog_n_ends
} cam_jog_end_t;

/// An order. Lengths are nm / 1024, speeds nm / 1024 per plan.
typedef struct {
    uint32_t serial;       ///< another one begins another order
    uint32_t until;        ///< [tick] it holds before this one
    cam_jog_phase_t begin; ///< rest, jog, step, here or search
    hal_axis_t axis;
    int32_t sense;             ///< +1, -1: of a jog, and of the search for the switch
    bool has_index;            ///< homing goes on to the index
    int32_t speed_q10;         ///< of jog, step and search
    int32_t slow_q10;          ///< off the switch, and to the index
    int64_t low_q10, high_q10; ///< travel, that of homing is wider
    int64_t distance_q10;      ///< of a step, signed; homing: travel that each phase may take
    int32_t home_nm;           ///< [nm] U at its home
} cam_jog_order_t;

/// What the plan needs in the state manual.
typedef struct {
    cam_motion_limits_t limits[hal_n_axes]; ///< per plan: speed of jogs, gentle acceleration; that
                                            ///< of U is per tick
    int64_t u_end_q10;                      ///< [nm / 1024] end of U's stroke
    cam_jog_order_t order;
} cam_jog_config_t;

/// State; zero-initialised nothing was ordered and nothing is homed.
typedef struct {
    uint32_t serial; ///< of the last order that was begun
    cam_jog_phase_t phase;
    cam_jog_end_t end; ///< of that order
    hal_axis_t axis;
    int64_t target_q10;           ///< [nm / 1024] where the phase ends
    uint32_t homed;               ///< bit of an axis: its home was found, and is not yet forgotten
    uint32_t n_found;             ///< homes that were found since the start
    int32_t found_nm[hal_n_axes]; ///< [nm] where the port counted the axis at its home
} cam_jog_t;

#endif
