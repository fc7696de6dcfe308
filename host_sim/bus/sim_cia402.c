// SPDX-License-Identifier: Apache-2.0
#include "sim_cia402.h"

/// Bits of the control word, CiA 402-2, object 6040h.
enum {
    switch_on = 1u << 0,
    enable_voltage = 1u << 1,
    no_quick_stop = 1u << 2,
    enable_operation = 1u << 3,
    fault_reset = 1u << 7,
};

/// Bits of the status word that do not depend on the state alone, object 6041h.
enum { voltage_enabled = 1u << 4, remote = 1u << 9, follows_command = 1u << 12 };

void sim_cia402_init(sim_cia402_t *d)
{
    *d = (sim_cia402_t){.power = sim_power_not_ready};
}

void sim_cia402_boot(sim_cia402_t *d)
{
    if (d->power == sim_power_not_ready) {
        d->power = sim_power_switch_on_disabled;
    }
}

/// Bit 1 low: no torque, from wherever there may be some.
static sim_power_t without_voltage(sim_power_t power)
{
    switch (power) {
    case sim_power_ready_to_switch_on:
    case sim_power_switched_on:
    case sim_power_operation_enabled:
    case sim_power_quick_stop_active:
        return sim_power_switch_on_disabled;
    default:
        return power;
    }
}

/// Bit 2 low.
static sim_power_t quickly_stopped(sim_power_t power)
{
    switch (power) {
    case sim_power_ready_to_switch_on:
    case sim_power_switched_on:
        return sim_power_switch_on_disabled;
    case sim_power_operation_enabled:
        return sim_power_quick_stop_active;
    default:
        return power;
    }
}

/// Bit 0 low, the two above high.
static sim_power_t shut_down(sim_power_t power)
{
    switch (power) {
    case sim_power_switch_on_disabled:
    case sim_power_switched_on:
    case sim_power_operation_enabled:
        return sim_power_ready_to_switch_on;
    default:
        return power;
    }
}

/// Bits 0 to 2 high, bit 3 low.
static sim_power_t switched_on(sim_power_t power)
{
    switch (power) {
    case sim_power_ready_to_switch_on:
    case sim_power_operation_enabled:
        return sim_power_switched_on;
    default:
        return power;
    }
}

/// Bits 0 to 3 high: one step towards operation.
static sim_power_t enabled(sim_power_t power)
{
    switch (power) {
    case sim_power_ready_to_switch_on:
        return sim_power_switched_on;
    case sim_power_switched_on:
    case sim_power_quick_stop_active:
        return sim_power_operation_enabled;
    default:
        return power;
    }
}

void sim_cia402_control(sim_cia402_t *d, uint32_t control_word)
{
    const bool is_reset = (control_word & fault_reset) != 0u;
    const bool is_rising = is_reset && !d->is_reset_held;
    d->is_reset_held = is_reset;
    if (d->power == sim_power_fault) {
        d->power = is_rising ? sim_power_switch_on_disabled : sim_power_fault;
    } else if (is_reset) {
        return;
    } else if ((control_word & enable_voltage) == 0u) {
        d->power = without_voltage(d->power);
    } else if ((control_word & no_quick_stop) == 0u) {
        d->power = quickly_stopped(d->power);
    } else if ((control_word & switch_on) == 0u) {
        d->power = shut_down(d->power);
    } else if ((control_word & enable_operation) == 0u) {
        d->power = switched_on(d->power);
    } else {
        d->power = enabled(d->power);
    }
}

void sim_cia402_fail(sim_cia402_t *d)
{
    if (d->power != sim_power_fault) {
        d->power = sim_power_fault_reaction_active;
    }
}

void sim_cia402_rest(sim_cia402_t *d)
{
    if (d->power == sim_power_quick_stop_active) {
        d->power = sim_power_switch_on_disabled;
    } else if (d->power == sim_power_fault_reaction_active) {
        d->power = sim_power_fault;
    }
}

uint32_t sim_cia402_status(const sim_cia402_t *d)
{
    static const uint32_t word[] = {
        [sim_power_not_ready] = 0x00u,
        [sim_power_switch_on_disabled] = 0x40u,
        [sim_power_ready_to_switch_on] = 0x21u,
        [sim_power_switched_on] = 0x23u,
        [sim_power_operation_enabled] = 0x27u | follows_command,
        [sim_power_quick_stop_active] = 0x07u,
        [sim_power_fault_reaction_active] = 0x0Fu,
        [sim_power_fault] = 0x08u,
    };
    return word[d->power] | voltage_enabled | remote;
}
