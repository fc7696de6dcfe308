// SPDX-License-Identifier: Apache-2.0
#include "cam_param.h"

void cam_rights_init(cam_rights_t *r, const hal_operator_t *port, uint32_t tick_hz)
{
    *r = (cam_rights_t){.port = *port,
                        .tick_hz = tick_hz,
                        .session = (uint8_t)(port->nonce & 0xFFu),
                        .is_key_on = true}; // a key left on does not unlock until it is seen off
}

// Command

cam_err_t cam_rights_take(cam_rights_t *r, uint8_t sender, bool is_over, uint32_t tick)
{
    if (sender == 0u || sender > (uint8_t)cam_rights_most_sender) {
        return cam_err_frame;
    }
    if (r->commander != 0u && !is_over) {
        return cam_err_not_commander;
    }
    r->n_take_overs += r->commander != 0u ? 1u : 0u;
    r->commander = sender;
    r->session = (uint8_t)(r->session % UINT8_MAX + 1u); // neither 0 nor that of the last session
    r->heard_tick = tick;
    cam_rights_lock(r);
    return cam_ok;
}

void cam_rights_release(cam_rights_t *r)
{
    r->commander = 0;
    cam_rights_lock(r);
}

bool cam_rights_is_commander(const cam_rights_t *r, uint8_t sender, uint8_t session)
{
    return r->commander != 0u && sender == r->commander && session == r->session;
}

void cam_rights_hear(cam_rights_t *r, uint32_t tick)
{
    r->heard_tick = tick;
}

static bool has_passed(const cam_rights_t *r, uint32_t from, uint32_t tick, uint32_t seconds)
{
    return tick - from > seconds * r->tick_hz;
}

// Level

void cam_rights_lock(cam_rights_t *r)
{
    r->level = cam_level_locked;
}

/// Turning the key on unlocks the level for the present commander; turning it off locks it.
static void watch_key(cam_rights_t *r, uint32_t inputs, uint32_t tick)
{
    const bool was_on = r->is_key_on;
    r->is_key_on = r->port.has_key && (inputs & (uint32_t)hal_in_key) != 0u;
    if (r->is_key_on && !was_on && r->commander != 0u && r->level == cam_level_locked) {
        r->level = cam_level_key;
        r->level_tick = tick;
    }
    if (!r->is_key_on) {
        cam_rights_lock(r);
    }
}

bool cam_rights_poll(cam_rights_t *r, uint32_t inputs, uint32_t tick)
{
    const bool is_lost =
        r->commander != 0u && has_passed(r, r->heard_tick, tick, (uint32_t)cam_rights_patience_s);
    if (is_lost) {
        r->n_losses++;
        cam_rights_release(r);
    }
    watch_key(r, inputs, tick);
    if (r->level != cam_level_locked &&
        has_passed(r, r->level_tick, tick, (uint32_t)cam_rights_level_s)) {
        cam_rights_lock(r);
    }
    return is_lost;
}

cam_err_t cam_rights_check_level(const cam_rights_t *r)
{
    if (!r->is_bus_calling || r->level != cam_level_locked) {
        return cam_ok;
    }
    return r->port.has_key ? cam_err_locked : cam_err_lock_none;
}

uint32_t cam_rights_level_left_s(const cam_rights_t *r, uint32_t tick)
{
    const uint32_t whole = (uint32_t)cam_rights_level_s * r->tick_hz;
    const uint32_t passed = tick - r->level_tick;
    const bool is_left = r->level != cam_level_locked && passed < whole;
    return is_left ? (whole - passed + r->tick_hz - 1u) / r->tick_hz : 0u;
}
