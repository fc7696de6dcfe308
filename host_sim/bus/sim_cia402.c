// SPDX-License-Identifier: Apache-2.0
#include "sim_cia402.h"

void sim_cia402_init(sim_cia402_t *d)
{
    *d = (sim_cia402_t){.state = cia402_not_ready_to_switch_on};
}

void sim_cia402_boot(sim_cia402_t *d)
{
    if (d->state == cia402_not_ready_to_switch_on) {
        d->state = cia402_switch_on_disabled;
    }
}

/// Bit 1 low: no torque, from wherever there may be some.
static cia402_state_t without_voltage(cia402_state_t state)
{
    switch (state) {
    case cia402_ready_to_switch_on:
    case cia402_switched_on:
    case cia402_operation_enabled:
    case cia402_quick_stop_active:
        return cia402_switch_on_disabled;
    default:
        return state;
    }
}

/// Bit 2 low.
static cia402_state_t quickly_stopped(cia402_state_t state)
{
    switch (state) {
    case cia402_ready_to_switch_on:
    case cia402_switched_on:
        return cia402_switch_on_disabled;
    case cia402_operation_enabled:
        return cia402_quick_stop_active;
    default:
        return state;
    }
}

/// Bit 0 low, the two above high.
static cia402_state_t shut_down(cia402_state_t state)
{
    switch (state) {
    case cia402_switch_on_disabled:
    case cia402_switched_on:
    case cia402_operation_enabled:
        return cia402_ready_to_switch_on;
    default:
        return state;
    }
}

/// Bits 0 to 2 high, bit 3 low.
static cia402_state_t switched_on(cia402_state_t state)
{
    switch (state) {
    case cia402_ready_to_switch_on:
    case cia402_operation_enabled:
        return cia402_switched_on;
    default:
        return state;
    }
}

/// Bits 0 to 3 high: one step towards operation.
static cia402_state_t enabled(cia402_state_t state)
{
    switch (state) {
    case cia402_ready_to_switch_on:
        return cia402_switched_on;
    case cia402_switched_on:
    case cia402_quick_stop_active:
        return cia402_operation_enabled;
    default:
        return state;
    }
}

void sim_cia402_control(sim_cia402_t *d, uint32_t control_word)
{
    const bool is_reset = (control_word & cia402_bit_fault_reset) != 0u;
    const bool is_rising = is_reset && !d->is_reset_held;
    d->is_reset_held = is_reset;
    if (d->state == cia402_fault) {
        d->state = is_rising ? cia402_switch_on_disabled : cia402_fault;
    } else if (is_reset) {
        return;
    } else if ((control_word & cia402_bit_enable_voltage) == 0u) {
        d->state = without_voltage(d->state);
    } else if ((control_word & cia402_bit_no_quick_stop) == 0u) {
        d->state = quickly_stopped(d->state);
    } else if ((control_word & cia402_bit_switch_on) == 0u) {
        d->state = shut_down(d->state);
    } else if ((control_word & cia402_bit_enable_operation) == 0u) {
        d->state = switched_on(d->state);
    } else {
        d->state = enabled(d->state);
    }
}

void sim_cia402_fail(sim_cia402_t *d)
{
    if (d->state != cia402_fault) {
        d->state = cia402_fault_reaction_active;
    }
}

void sim_cia402_rest(sim_cia402_t *d)
{
    if (d->state == cia402_quick_stop_active) {
        d->state = cia402_switch_on_disabled;
    } else if (d->state == cia402_fault_reaction_active) {
        d->state = cia402_fault;
    }
}

uint32_t sim_cia402_status(const sim_cia402_t *d)
{
    const uint32_t follows = sim_cia402_is_following(d) ? cia402_bit_follows_command : 0u;
    return cia402_pattern[d->state].value | follows | cia402_bit_voltage_enabled |
           cia402_bit_remote;
}
