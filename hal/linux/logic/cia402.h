// SPDX-License-Identifier: Apache-2.0
/// cia402: the state machine of a drive as its controller sees it: status word in, control word
/// out. Pure. Source: CiA 402-2 (IEC 61800-7-201), "Finite state automaton", 6040h, 6041h.
#ifndef CIA402_H
#define CIA402_H

#include <stdint.h> // uint16_t

typedef enum {
    cia402_not_ready_to_switch_on,
    cia402_switch_on_disabled,
    cia402_ready_to_switch_on,
    cia402_switched_on,
    cia402_operation_enabled,
    cia402_quick_stop_active,
    cia402_fault_reaction_active,
    cia402_fault,
} cia402_state_t;

/// Control words (6040h).
enum {
    cia402_disable_voltage = 0x00,
    cia402_quick_stop = 0x02,
    cia402_shutdown = 0x06,
    cia402_switch_on = 0x07,
    cia402_enable_operation = 0x0F,
    cia402_fault_reset = 0x80, ///< its rising edge
};

/// Where a drive shall be led.
typedef enum {
    cia402_goal_rest, ///< without torque, one step before switched on; a motion ends by quick stop
    cia402_goal_enabled, ///< following its set-point
    cia402_goal_off,     ///< without voltage; a motion ends by quick stop
    cia402_goal_reset,   ///< out of the state fault; otherwise as rest
} cia402_goal_t;

/// @param status  6041h
cia402_state_t cia402_state(uint16_t status);

/// @return the control word of the next step to the goal. In quick stop active it stays quick stop:
/// the drive leaves that state on its own once it stands.
uint16_t cia402_control(cia402_state_t state, cia402_goal_t goal);

#endif
