// SPDX-License-Identifier: Apache-2.0
#include "lin_bus.h"
#include "canopen.h" // common_get_u16

enum { reset_interval_ns = 1000000000, quick_stop_most_ns = 2000000000 };

void lin_drive_init(lin_drive_t *d, int64_t node, int64_t counts, int64_t nm)
{
    *d = (lin_drive_t){.node.id = (uint32_t)node,
                       .counts = counts,
                       .nm = nm,
                       .reset_ns = -(int64_t)reset_interval_ns};
    d->is_ready = node == 0;
}

bool lin_drive_receive(lin_drive_t *d, const hal_can_frame_t *frame, int64_t ns)
{
    if (d->node.id != 0u && frame->id == canopen_id_tpdo1 + d->node.id && frame->n == 6u) {
        d->state = lin_cia402_state(common_get_u16(frame->data));
        d->actual = (int32_t)common_get_u32(frame->data + 2);
        d->has_status = true;
        d->status_ns = ns;
        return true;
    }
    return lin_node_receive(&d->node, frame, ns);
}

void lin_drive_judge(lin_drive_t *d, int64_t now_ns, const lin_timeouts_t *timeouts)
{
    if (d->node.id == 0u) {
        return;
    }
    d->loss = lin_node_judge(&d->node, now_ns, timeouts->node_ns);
    if (d->loss == lin_loss_none && (!d->has_status || now_ns - d->status_ns > timeouts->pdo_ns)) {
        d->loss = lin_loss_pdo;
    }
    const bool is_failed = d->node.emcy != 0u || d->state == cia402_not_ready_to_switch_on ||
                           d->state == cia402_fault_reaction_active || d->state == cia402_fault;
    const bool is_following = d->state == cia402_operation_enabled;
    // A drive may take some time to reach operation enabled; afterwards it must stay there.
    const bool has_time = !d->has_followed && now_ns - d->enabled_ns < timeouts->enable_ns;
    d->is_ready =
        d->loss == lin_loss_none && !is_failed && (!d->is_enabled || is_following || has_time);
    d->has_followed = d->is_enabled && (d->has_followed || d->state == cia402_operation_enabled);
}

void lin_drive_enable(lin_drive_t *d, bool is_enabled, int64_t now_ns)
{
    if (is_enabled && !d->is_enabled) {
        d->enabled_ns = now_ns;
        d->has_followed = false;
    }
    d->is_enabled = is_enabled;
}

void lin_drive_forget(lin_drive_t *d)
{
    d->node.emcy = 0;
}

/// Choose the target state. A fault reset is sent at most once a second, for one tick, because the
/// drive acts on the rising edge.
static lin_cia402_goal_t goal_of(lin_drive_t *d, int64_t now_ns, bool may_reset, bool is_stopping)
{
    if (is_stopping) {
        return lin_cia402_off;
    }
    if (d->is_enabled) {
        return lin_cia402_enabled;
    }
    if (may_reset && d->state == cia402_fault && now_ns - d->reset_ns >= reset_interval_ns) {
        d->reset_ns = now_ns;
        lin_drive_forget(d);
        return lin_cia402_reset;
    }
    return lin_cia402_rest;
}

uint16_t lin_drive_control(lin_drive_t *d, int64_t now_ns, bool may_reset, bool is_stopping)
{
    const lin_cia402_goal_t goal = goal_of(d, now_ns, may_reset, is_stopping);
    if (d->state != cia402_quick_stop_active) {
        d->quick_stop_ns = 0;
    } else if (d->quick_stop_ns == 0) {
        d->quick_stop_ns = now_ns;
    } else if (now_ns - d->quick_stop_ns > quick_stop_most_ns) {
        return lin_cia402_disable_voltage; // the drive is set to stay there (605Ah)
    }
    return lin_cia402_control(d->state, goal);
}

int32_t lin_drive_units(const lin_drive_t *d, int64_t nm)
{
    return lin_clamp_i32(lin_div_round(nm * d->counts, d->nm));
}

int32_t lin_drive_actual_nm(const lin_drive_t *d)
{
    return lin_clamp_i32(lin_div_round(d->actual * d->nm, d->counts));
}

uint32_t lin_drive_unit_pm(const lin_drive_t *d)
{
    if (d->node.id == 0u) {
        return 0;
    }
    const int64_t unit_pm = lin_div_round(d->nm * 1000, d->counts);
    return (uint32_t)lin_clamp_i32(unit_pm < 0 ? -unit_pm : unit_pm);
}
