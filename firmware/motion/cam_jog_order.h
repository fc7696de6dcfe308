// SPDX-License-Identifier: Apache-2.0
/// cam_jog_order: a jog, step or homing order for one axis, and its progress.
///
/// An order is a part of the configuration (cam_config.h), so a replay includes it. It begins when
/// its serial number is new, and expires at the tick it names; the slow side extends it while the
/// commanding node is alive. Positions are in port coordinates.
#ifndef CAM_JOG_ORDER_H
#define CAM_JOG_ORDER_H

#include "cam_move_profile.h" // cam_motion_limits_t
#include "hal/hal.h"          // hal_axis_t
#include <stdbool.h>          // bool
#include <stdint.h>           // int32_t, int64_t, uint32_t

/// Phase of an order. The number is part of the CAN protocol.
typedef enum {
    cam_jog_rest,    ///< none: all axes brake and stop
    cam_jog_jog,     ///< the axis moves until the order expires
    cam_jog_step,    ///< ... by a distance
    cam_jog_here,    ///< homing: the present position is the home
    cam_jog_search,  ///< homing: towards the switch
    cam_jog_release, ///< homing: back, off the switch
    cam_jog_index,   ///< homing: on to the index
    cam_jog_n_phases
} cam_jog_phase_t;

/// Result of the last order. The number is part of the CAN protocol.
typedef enum {
    cam_jog_never,      ///< there was none
    cam_jog_runs,       ///< in progress
    cam_jog_done,       ///< the step is made, the home is found
    cam_jog_stopped,    ///< cut short by stop, disable or a fault
    cam_jog_silent,     ///< cut short because the commanding node went silent
    cam_jog_limit,      ///< the axis reached the limit of its travel
    cam_jog_no_switch,  ///< no switch within the travel of the search
    cam_jog_no_release, ///< the switch stayed active over that travel
    cam_jog_no_index,   ///< no index within that travel
    cam_jog_no_stroke,  ///< with the home found, U would be outside its stroke
    cam_jog_n_ends
} cam_jog_end_t;

/// An order. Lengths are nm / 1024, speeds nm / 1024 per plan.
typedef struct {
    uint32_t serial;       ///< a new number begins a new order
    uint32_t until;        ///< [tick] at which it expires
    cam_jog_phase_t begin; ///< rest, jog, step, here or search
    hal_axis_t axis;
    int32_t sense;             ///< +1, -1: of a jog, and of the search for the switch
    bool has_index;            ///< homing goes on to the index
    int32_t speed_q10;         ///< of jog, step and search
    int32_t slow_q10;          ///< off the switch, and to the index
    int64_t low_q10, high_q10; ///< travel, that of homing is wider
    int64_t distance_q10;      ///< of a step, signed; homing: travel allowed for each phase
    int32_t home_nm;           ///< [nm] U at its home
} cam_jog_order_t;

/// Configuration of the state manual.
typedef struct {
    cam_motion_limits_t limits[hal_n_axes]; ///< per plan: speed of jogs, gentle acceleration; that
                                            ///< of U is per tick
    int64_t u_end_q10;                      ///< [nm / 1024] end of U's stroke
    cam_jog_order_t order;
} cam_jog_config_t;

/// State; zero-initialised: no order, nothing homed.
typedef struct {
    uint32_t serial; ///< of the last order begun
    cam_jog_phase_t phase;
    cam_jog_end_t end; ///< of that order
    hal_axis_t axis;
    int64_t target_q10;           ///< [nm / 1024] where the phase ends
    uint32_t homed;               ///< bit of an axis: its home is known
    uint32_t n_found;             ///< homes found since start
    int32_t found_nm[hal_n_axes]; ///< [nm] port position of the axis at its home
} cam_jog_t;

#endif
