// SPDX-License-Identifier: Apache-2.0
/// cia402: states of a drive, bits of its control and status words.
/// Source: CiA 402-2 (IEC 61800-7-201), "Finite state automaton", objects 6040h and 6041h.
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
    cia402_n_states
} cia402_state_t;

/// Bits of the control word (6040h).
enum {
    cia402_bit_switch_on = 1 << 0,
    cia402_bit_enable_voltage = 1 << 1,
    cia402_bit_no_quick_stop = 1 << 2,
    cia402_bit_enable_operation = 1 << 3,
    cia402_bit_fault_reset = 1 << 7, ///< acts on its rising edge
};

/// Bits of the status word (6041h) that do not follow from the state alone.
enum {
    cia402_bit_voltage_enabled = 1 << 4,
    cia402_bit_remote = 1 << 9,
    cia402_bit_follows_command = 1 << 12,
};

/// A drive is in a state when its status word has `value` in the bits of `mask`.
typedef struct {
    uint16_t mask, value;
} cia402_pattern_t;

extern const cia402_pattern_t cia402_pattern[cia402_n_states];

#endif
