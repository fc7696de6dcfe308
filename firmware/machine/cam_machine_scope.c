// SPDX-License-Identifier: Apache-2.0
#include "cam_machine_inner.h"
#include "cam_recorder.h" // cam_blackbox_begin

void cam_machine_blackbox(cam_machine_t *m)
{
    m->has_box = true;
    m->is_box_kept = cam_blackbox_restore(&m->scope, hal_scope_memory().n_kept);
}

cam_err_t cam_machine_scope_start(cam_machine_t *m)
{
    if (m->identify.phase != cam_identify_none) {
        return cam_err_state;
    }
    if (cam_blackbox_is_unread(&m->scope)) {
        return cam_err_scope_unread;
    }
    return cam_scope_begin(&m->scope, &m->scope.set, cam_scope_user, 0, cam_status_tick(m->core));
}

void cam_machine_scope_stop(cam_machine_t *m)
{
    if (m->scope.use == cam_scope_user) {
        cam_scope_stop(&m->scope);
    }
}

/// Discard recording and wave: the black box gets all the memory.
static void give_up(cam_machine_t *m)
{
    m->identify.n = 0;
    m->identify.is_open = false;
    cam_scope_reserve(&m->scope, 0);
}

cam_err_t cam_machine_release(cam_machine_t *m)
{
    if (m->identify.phase != cam_identify_none) {
        return cam_err_state;
    }
    if (cam_blackbox_is_unread(&m->scope)) {
        hal_scope_keep(m->scope.words, 0);
    }
    give_up(m);
    return cam_ok;
}

static cam_err_t set_wave_unit(cam_machine_t *m, int32_t value)
{
    if (value != 0 && value != 1) {
        return cam_err_scope_range;
    }
    if (value == 1 && !hal_takes_force()) {
        return cam_err_wave_unit;
    }
    m->identify.is_force = value == 1;
    return cam_ok;
}

cam_err_t cam_machine_scope_set(cam_machine_t *m, uint32_t field, int32_t value)
{
    if (field == cam_scope_field_place_nm) {
        m->identify.place_nm = value;
        return cam_ok;
    }
    if (field == cam_scope_field_wave_unit) {
        return set_wave_unit(m, value);
    }
    return cam_scope_set(&m->scope, field, value);
}

cam_err_t cam_machine_scope_get(const cam_machine_t *m, uint32_t field, int32_t *value)
{
    switch (field) {
    case cam_scope_field_place_nm:
        *value = m->identify.place_nm;
        return cam_ok;
    case cam_scope_field_wave_unit:
        *value = m->identify.is_force ? 1 : 0;
        return cam_ok;
    case cam_scope_field_excited:
        *value = (int32_t)m->identify.excited;
        return cam_ok;
    case cam_scope_field_n_fall:
        *value = (int32_t)m->identify.n_fall;
        return cam_ok;
    default:
        return cam_scope_get(&m->scope, field, value);
    }
}

// The black box

/// Save the box of a fault in the port, once. Restart the box when the recorder is free.
static void poll_box(cam_machine_t *m)
{
    const uint32_t tick = cam_status_tick(m->core);
    if (cam_blackbox_is_unread(&m->scope)) {
        if (!m->is_box_kept) {
            cam_blackbox_keep(&m->scope);
            m->is_box_kept = true;
        }
        return;
    }
    const uint32_t patience = m->tick_hz * (uint32_t)cam_scope_patience_s;
    if (m->scope.phase == cam_scope_done && m->identify.phase == cam_identify_none &&
        !m->identify.is_open && tick - m->scope.last_tick > patience) {
        give_up(m);
    }
    if (m->scope.phase == cam_scope_idle && cam_blackbox_begin(&m->scope, tick) == cam_ok) {
        m->is_box_kept = false;
    }
}

// The trace ring

void cam_machine_scope_poll(cam_machine_t *m)
{
    cam_tick_record_t record;
    for (uint32_t i = 0; i < (uint32_t)cam_trace_capacity && cam_scope_is_on(&m->scope) &&
                         cam_trace_pop(&m->core->trace, &record);
         i++) {
        cam_scope_take(&m->scope, &record);
    }
    if (m->has_box) {
        poll_box(m);
    }
}
