// SPDX-License-Identifier: Apache-2.0
#include "lin_bus.h"

cia402_state_t lin_cia402_state(uint16_t status)
{
    for (int i = 0; i < cia402_n_states; i++) {
        if ((status & cia402_pattern[i].mask) == cia402_pattern[i].value) {
            return (cia402_state_t)i;
        }
    }
    return cia402_not_ready_to_switch_on;
}

static uint16_t enabling_word(cia402_state_t state)
{
    switch (state) {
    case cia402_switch_on_disabled:
        return lin_cia402_shutdown;
    case cia402_ready_to_switch_on:
        return lin_cia402_switch_on;
    case cia402_switched_on:
    case cia402_operation_enabled:
        return lin_cia402_enable_operation;
    default:
        return lin_cia402_disable_voltage;
    }
}

uint16_t lin_cia402_control(cia402_state_t state, lin_cia402_goal_t goal)
{
    if (state == cia402_quick_stop_active ||
        (state == cia402_operation_enabled && goal != lin_cia402_enabled)) {
        return lin_cia402_quick_stop;
    }
    if (goal == lin_cia402_enabled) {
        return enabling_word(state);
    }
    if (goal == lin_cia402_reset && state == cia402_fault) {
        return lin_cia402_fault_reset;
    }
    return goal == lin_cia402_off ? lin_cia402_disable_voltage : lin_cia402_shutdown;
}
