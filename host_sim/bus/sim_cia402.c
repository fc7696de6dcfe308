// SPDX-License-Identifier: Apache-2.0
#include "sim_bus.h"
#include <stddef.h> // size_t

/// A state as a bit in a set of states.
#define IN(state) (1u << cia402_##state)

enum {
    voltage = cia402_bit_enable_voltage,
    no_stop = cia402_bit_no_quick_stop,
    on = cia402_bit_switch_on,
    enable = cia402_bit_enable_operation,
};

/// A control word takes the first step that matches its bits under `mask` and the present state in
/// `from`.
static const struct {
    uint32_t mask, bits, from;
    cia402_state_t to;
} steps[] = {
    // Disable voltage: from every state that may have torque.
    {voltage, 0,
     IN(ready_to_switch_on) | IN(switched_on) | IN(operation_enabled) | IN(quick_stop_active),
     cia402_switch_on_disabled},
    // Quick stop.
    {voltage | no_stop, voltage, IN(ready_to_switch_on) | IN(switched_on),
     cia402_switch_on_disabled},
    {voltage | no_stop, voltage, IN(operation_enabled), cia402_quick_stop_active},
    // Shutdown.
    {voltage | no_stop | on, voltage | no_stop,
     IN(switch_on_disabled) | IN(switched_on) | IN(operation_enabled), cia402_ready_to_switch_on},
    // Switch on, or disable operation.
    {voltage | no_stop | on | enable, voltage | no_stop | on,
     IN(ready_to_switch_on) | IN(operation_enabled), cia402_switched_on},
    // Enable operation: one step towards it at a time.
    {voltage | no_stop | on | enable, voltage | no_stop | on | enable, IN(ready_to_switch_on),
     cia402_switched_on},
    {voltage | no_stop | on | enable, voltage | no_stop | on | enable,
     IN(switched_on) | IN(quick_stop_active), cia402_operation_enabled},
};

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

void sim_cia402_control(sim_cia402_t *d, uint32_t control_word)
{
    const bool is_reset = (control_word & cia402_bit_fault_reset) != 0u;
    const bool is_rising = is_reset && !d->is_reset_held;
    d->is_reset_held = is_reset;
    if (d->state == cia402_fault) {
        d->state = is_rising ? cia402_switch_on_disabled : cia402_fault;
        return;
    }
    for (size_t i = 0; !is_reset && i < sizeof steps / sizeof steps[0]; i++) {
        if ((control_word & steps[i].mask) == steps[i].bits &&
            (steps[i].from >> d->state & 1u) != 0u) {
            d->state = steps[i].to;
            return;
        }
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
