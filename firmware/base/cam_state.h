// SPDX-License-Identifier: Apache-2.0
/// cam_state: states, requests and faults.
#ifndef CAM_STATE_H
#define CAM_STATE_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, uint32_t

// clang-format off
/// States of the machine. The interrupt owns the state; the slow side only requests changes.
///
///     off --enable--> homing --index found--> ready --start--> engaging --> cutting --> disengaging --> ready
///                                       ready --start, rehearse_turns > 0--> rehearsing --> engaging
///     homing, ready --disable--> off
///     engaging, cutting --stop--> disengaging; while the axes approach: ready
///     rehearsing --stop, as soon as U has come to rest--> ready
///     cutting --hold, once Z rests--> holding --resume--> cutting; holding --stop--> disengaging
///     ready --identify--> identifying --end of the wave, stop--> ready
///     off --manual--> manual --disable, as soon as the axes rest--> off
///     any but off --fault--> fault --reset, after the retract--> off
///
/// Homing ends when the index is found, the spindle turns and the axes rest. Hold and resume are no
/// requests: the configuration sets the feed override to 0 and back.
// clang-format on
typedef enum {
    cam_state_off,         ///< drives not enabled, set-points follow the measured axes
    cam_state_homing,      ///< enabled, U retracts, the spindle's index is searched
    cam_state_ready,       ///< angle known, tool retracted from the workpiece
    cam_state_engaging,    ///< the axes approach, then depth and amplitude rise
    cam_state_cutting,     ///< full amplitude, Z feeds
    cam_state_disengaging, ///< depth and amplitude fall while Z rests
    cam_state_fault,       ///< retracting or retracted, latched until reset
    cam_state_rehearsing,  ///< X stays clear while the section of the first height plays
    cam_state_identifying, ///< as ready, but U plays a downloaded wave about its position
    cam_state_manual,      ///< enabled, spindle at rest, axes are jogged and homed
    cam_state_holding,     ///< as cutting, but Z rests
    cam_n_states
} cam_state_t;

/// @return whether the axes follow the spindle's angle in this state
static inline bool cam_state_is_in_work(cam_state_t state)
{
    return state == cam_state_engaging || state == cam_state_cutting ||
           state == cam_state_disengaging || state == cam_state_rehearsing ||
           state == cam_state_holding;
}

/// Requests of the slow side to the interrupt, which obeys one in the next tick if the state allows
/// it (the stop of a cut in the next plan) and ignores it otherwise.
typedef enum {
    cam_request_none,
    cam_request_enable,
    cam_request_disable,
    cam_request_start,
    cam_request_stop,
    cam_request_reset,
    cam_request_table_fault, ///< raise fault `table`: the background check found damage
    cam_request_identify,    ///< play the wave of the configuration on U
    cam_request_manual,      ///< enable the drives without the spindle, for jogging (cam_plan.h)
} cam_request_t;

/// Faults in the order of their bits, each with a clause for people. FAULTS.md lists how soon each
/// is detected and how the controller reacts.
#define CAM_FAULTS(X)                                                                              \
    X(estop, "emergency stop")                                                                     \
    X(drive, "a drive is not ready")                                                               \
    X(bus, "a node on the bus went silent or frames were lost")                                    \
    X(late_tick, "the tick came late")                                                             \
    X(encoder_jump, "encoder counts jumped")                                                       \
    X(lost_counts, "encoder counts lost or gained between two index edges")                        \
    X(index_missing, "no index edge where one was due")                                            \
    X(reverse, "spindle turns against the sense of cutting")                                       \
    X(spindle_stopped, "the spindle does not turn in the sense of cutting")                        \
    X(overspeed, "spindle faster than this table allows")                                          \
    X(following_error, "U does not follow")                                                        \
    X(setpoint_speed, "U set-point moves faster than U can")                                       \
    X(setpoint_acceleration, "U set-point accelerates more than U can")                            \
    X(setpoint_range, "U set-point leaves the stroke")                                             \
    X(z_range, "Z left the table")                                                                 \
    X(table, "table damaged")                                                                      \
    X(swing, "the tool's swing does not follow")                                                   \
    X(command, "an axis command exceeds its limits")                                               \
    X(u_travel, "U is at the end of its travel or cannot stop before it")                          \
    X(u_runaway, "U does not move as its force asks")                                              \
    X(u_force, "the force of U was at its limit for too long")

/// A fault: its bit number in a fault mask.
typedef enum {
#define CAM_FAULT_ID(name, what) cam_fault_##name,
    CAM_FAULTS(CAM_FAULT_ID)
#undef CAM_FAULT_ID
        cam_n_faults
} cam_fault_t;

_Static_assert(cam_n_faults <= 32, "a fault mask is one word");

/// @return the bit of a fault in a fault mask, for example CAM_FAULT_BIT(estop) = 1
#define CAM_FAULT_BIT(name) (UINT32_C(1) << cam_fault_##name)

/// @return a state's name, lower case, static; "?" for any other value
const char *cam_state_name(cam_state_t state);

/// @return a fault's short name as in the list, static; "?" for any other value
const char *cam_fault_name(cam_fault_t fault);

/// @return a fault's meaning, one clause, static; "?" for any other value
const char *cam_fault_text(cam_fault_t fault);

#endif
