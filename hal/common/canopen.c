// SPDX-License-Identifier: Apache-2.0
#include "canopen.h"

const cia402_pattern_t cia402_pattern[cia402_n_states] = {
    [cia402_not_ready_to_switch_on] = {0x4F, 0x00}, [cia402_switch_on_disabled] = {0x4F, 0x40},
    [cia402_ready_to_switch_on] = {0x6F, 0x21},     [cia402_switched_on] = {0x6F, 0x23},
    [cia402_operation_enabled] = {0x6F, 0x27},      [cia402_quick_stop_active] = {0x6F, 0x07},
    [cia402_fault_reaction_active] = {0x4F, 0x0F},  [cia402_fault] = {0x4F, 0x08},
};
