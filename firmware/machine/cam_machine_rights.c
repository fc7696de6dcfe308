// SPDX-License-Identifier: Apache-2.0
#include "cam_machine_inner.h" // cam_machine_is_pending
#include "cam_plan.h"          // cam_plan_ticks

/// Times of the acknowledge button (cam_plan.h).
enum { settle_ms = 20, least_ms = 50, most_ms = 2000, good_s = 60 };

/// @return [plans], rounded up
static uint32_t plans_of_ms(uint32_t ms, uint32_t tick_hz)
{
    const uint64_t per_plan = (uint64_t)cam_plan_ticks(tick_hz) * 1000u;
    return (uint32_t)(((uint64_t)ms * tick_hz + per_plan - 1u) / per_plan);
}

cam_acknowledge_config_t cam_machine_acknowledge_config(const cam_machine_t *m)
{
    return (cam_acknowledge_config_t){
        .is_demanded = !m->rights.port.is_acknowledge_waived,
        .settle_plans = plans_of_ms(settle_ms, m->tick_hz),
        .least_plans = plans_of_ms(least_ms, m->tick_hz),
        .most_plans = plans_of_ms(most_ms, m->tick_hz),
        .good_plans = plans_of_ms(good_s * 1000u, m->tick_hz),
    };
}

static cam_button_t button_of(const cam_machine_t *m, const cam_status_t *status)
{
    const hal_operator_t *port = &m->rights.port;
    if (port->is_acknowledge_waived) {
        return cam_button_waived;
    }
    if (!port->has_acknowledge) {
        return cam_button_none;
    }
    return status->acknowledge.phase >= cam_acknowledge_given ? cam_button_given
                                                              : cam_button_needed;
}

cam_err_t cam_machine_check_acknowledge(const cam_machine_t *m, const cam_status_t *status)
{
    const cam_button_t button = button_of(m, status);
    if (button == cam_button_none) {
        return cam_err_acknowledge_none;
    }
    return button == cam_button_needed ? cam_err_acknowledge : cam_ok;
}

void cam_machine_release_command(cam_machine_t *m)
{
    cam_rights_release(&m->rights);
    m->is_stop_due = true;
}

void cam_machine_rights_poll(cam_machine_t *m, const cam_status_t *status)
{
    m->is_stop_due = cam_rights_poll(&m->rights, status->inputs, status->tick) || m->is_stop_due;
    if (m->is_stop_due) {
        // A pending request may be a start, so wait until the interrupt has taken it.
        m->homes_again = false;
        m->is_stop_due = cam_machine_is_pending(m, status) || cam_machine_stop(m) == cam_err_busy;
    }
}

cam_rights_status_t cam_machine_rights(const cam_machine_t *m, const cam_status_t *status)
{
    const cam_acknowledge_config_t cfg = cam_machine_acknowledge_config(m);
    const uint32_t left = cam_acknowledge_left(&status->acknowledge, &cfg);
    const uint32_t per_s = plans_of_ms(1000, m->tick_hz);
    return (cam_rights_status_t){
        .commander = m->rights.commander,
        .n_take_overs = m->rights.n_take_overs,
        .n_losses = m->rights.n_losses,
        .level = m->rights.level,
        .level_left_s = cam_rights_level_left_s(&m->rights, status->tick),
        .button = button_of(m, status),
        .button_left_s = (left + per_s - 1u) / per_s,
    };
}
