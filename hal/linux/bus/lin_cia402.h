// SPDX-License-Identifier: Apache-2.0
/// lin_cia402: controller side of the drive state machine: status word in, control word out.
/// Pure. Source: CiA 402-2 (IEC 61800-7-201), "Finite state automaton", 6040h, 6041h.
#ifndef LIN_CIA402_H
#define LIN_CIA402_H

#include "cia402.h" // cia402_state_t
#include <stdint.h> // uint16_t

/// Control words (6040h).
enum {
    lin_cia402_disable_voltage = 0x00,
    lin_cia402_quick_stop = cia402_bit_enable_voltage,
    lin_cia402_shutdown = cia402_bit_enable_voltage | cia402_bit_no_quick_stop,
    lin_cia402_switch_on = lin_cia402_shutdown | cia402_bit_switch_on,
    lin_cia402_enable_operation = lin_cia402_switch_on | cia402_bit_enable_operation,
    lin_cia402_fault_reset = cia402_bit_fault_reset,
};

/// Target state of a drive.
typedef enum {
    lin_cia402_rest,    ///< ready to switch on, no torque; a moving drive makes a quick stop first
    lin_cia402_enabled, ///< following its set-point
    lin_cia402_off,     ///< no voltage; a moving drive makes a quick stop first
    lin_cia402_reset,   ///< fault reset if in fault; otherwise as rest
} lin_cia402_goal_t;

/// @param status  6041h
cia402_state_t lin_cia402_state(uint16_t status);

/// @return control word of the next step to the goal. In quick stop active it remains quick stop;
/// the drive leaves that state on its own at standstill.
uint16_t lin_cia402_control(cia402_state_t state, lin_cia402_goal_t goal);

#endif
