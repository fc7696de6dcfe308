// SPDX-License-Identifier: Apache-2.0
#include "cia402.h"
#include <stddef.h> // size_t

cia402_state_t cia402_state(uint16_t status)
{
    static const struct {
        uint16_t mask, value;
        cia402_state_t state;
    } patterns[] = {
        {0x4F, 0x40, cia402_switch_on_disabled},
        {0x6F, 0x21, cia402_ready_to_switch_on},
        {0x6F, 0x23, cia402_switched_on},
        {0x6F, 0x27, cia402_operation_enabled},
        {0x6F, 0x07, cia402_quick_stop_active},
        {0x4F, 0x0F, cia402_fault_reaction_active},
        {0x4F, 0x08, cia402_fault},
    };
    for (size_t i = 0; i < sizeof patterns / sizeof patterns[0]; i++) {
        if ((status & patterns[i].mask) == patterns[i].value) {
            return patterns[i].state;
        }
    }
    return cia402_not_ready_to_switch_on;
}

static uint16_t towards_enabled(cia402_state_t state)
{
    switch (state) {
    case cia402_switch_on_disabled:
        return cia402_shutdown;
    case cia402_ready_to_switch_on:
        return cia402_switch_on;
    case cia402_switched_on:
    case cia402_operation_enabled:
        return cia402_enable_operation;
    case cia402_not_ready_to_switch_on:
    case cia402_quick_stop_active:
    case cia402_fault_reaction_active:
    case cia402_fault:
        break;
    }
    return cia402_disable_voltage;
}

uint16_t cia402_control(cia402_state_t state, cia402_goal_t goal)
{
    if (state == cia402_quick_stop_active ||
        (state == cia402_operation_enabled && goal != cia402_goal_enabled)) {
        return cia402_quick_stop;
    }
    if (goal == cia402_goal_enabled) {
        return towards_enabled(state);
    }
    if (goal == cia402_goal_reset && state == cia402_fault) {
        return cia402_fault_reset;
    }
    return goal == cia402_goal_off ? cia402_disable_voltage : cia402_shutdown;
}
