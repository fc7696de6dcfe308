// SPDX-License-Identifier: Apache-2.0
/// canopen: constants and numbers of CiA 301; states and words of drives of CiA 402.
#ifndef CANOPEN_H
#define CANOPEN_H

#include <stdint.h> // int32_t, uint8_t, uint16_t, uint32_t

/// Frame identifiers (COB-ID); for frames of a node add its node number.
enum {
    canopen_id_nmt = 0x000,
    canopen_id_sync = 0x080,
    canopen_id_emcy = 0x080,
    canopen_id_tpdo1 = 0x180,
    canopen_id_rpdo1 = 0x200,
    canopen_id_rpdo2 = 0x300,
    canopen_id_heartbeat = 0x700,
};

/// Node states in the heartbeat.
enum {
    canopen_boot_up = 0x00,
    canopen_stopped = 0x04,
    canopen_operational = 0x05,
    canopen_pre_operational = 0x7F,
};

/// Commands of the network master, CiA 301, table "NMT protocol".
enum {
    canopen_start = 0x01,
    canopen_stop = 0x02,
    canopen_enter_pre_operational = 0x80,
    canopen_reset = 0x81,
    canopen_reset_communication = 0x82,
};

// Little-endian numbers in frame data (CiA 301, 7.1.4).

static inline uint16_t common_get_u16(const uint8_t *at)
{
    return (uint16_t)(at[0] | at[1] << 8);
}

static inline uint32_t common_get_u32(const uint8_t *at)
{
    return (uint32_t)common_get_u16(at) | (uint32_t)common_get_u16(at + 2) << 16;
}

static inline void common_put_u16(uint8_t *at, uint16_t value)
{
    at[0] = (uint8_t)(value & 0xFFu);
    at[1] = (uint8_t)(value >> 8);
}

static inline void common_put_u32(uint8_t *at, uint32_t value)
{
    common_put_u16(at, (uint16_t)(value & 0xFFFFu));
    common_put_u16(at + 2, (uint16_t)(value >> 16));
}

static inline void common_put_i32(uint8_t *at, int32_t value)
{
    common_put_u32(at, (uint32_t)value);
}

// States of a drive, bits of its control and status words.
// Source: CiA 402-2 (IEC 61800-7-201), "Finite state automaton", objects 6040h and 6041h.

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
