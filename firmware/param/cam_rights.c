// SPDX-License-Identifier: Apache-2.0
#include "cam_param.h"
#include "cam_param_inner.h" // cam_blake2b_keyed

void cam_rights_init(cam_rights_t *r, const hal_operator_t *port, uint32_t tick_hz)
{
    *r = (cam_rights_t){.port = *port,
                        .tick_hz = tick_hz,
                        .session = (uint8_t)(port->nonce & 0xFFu),
                        .is_key_on = true, // a key left on does not unlock until it is seen off
                        .challenge_tick = 0u - tick_hz,
                        .noise = port->nonce};
}

// Command

static void unlock(cam_rights_t *r, cam_level_t level, uint32_t tick)
{
    r->level = level;
    r->level_tick = tick;
}

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
    r->is_challenged = false;
    cam_rights_lock(r);
    return cam_ok;
}

void cam_rights_release(cam_rights_t *r)
{
    r->commander = 0;
    r->is_challenged = false;
    cam_rights_lock(r);
}

bool cam_rights_is_commander(const cam_rights_t *r, uint8_t sender, uint8_t session)
{
    return r->commander != 0u && sender == r->commander && session == r->session;
}

void cam_rights_hear(cam_rights_t *r, uint32_t tick)
{
    r->heard_tick = tick;
    r->noise = (r->noise ^ tick) * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
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

/// @param n_words  1 .. 3; different lengths give unrelated hashes
/// @return         first four bytes, the lowest first, of the words' keyed BLAKE2b
static uint32_t keyed(const cam_rights_t *r, const uint32_t *words, uint32_t n_words)
{
    enum { most_words = 3, word_bytes = 4 };
    uint8_t bytes[most_words * word_bytes];
    for (uint32_t i = 0; i < n_words * word_bytes; i++) {
        bytes[i] = (uint8_t)(words[i / word_bytes] >> (8u * (i % word_bytes)) & 0xFFu);
    }
    return cam_blake2b_keyed(r->port.secret, r->port.n_secret, bytes, n_words * word_bytes);
}

cam_err_t cam_rights_challenge(cam_rights_t *r, uint32_t tick, uint32_t *challenge)
{
    if (r->port.n_secret == 0u) {
        return r->port.has_key ? cam_err_locked : cam_err_lock_none;
    }
    if (tick - r->challenge_tick < r->tick_hz) {
        return cam_err_busy;
    }
    const uint32_t words[] = {(uint32_t)(r->noise & UINT32_MAX), (uint32_t)(r->noise >> 32), tick};
    r->challenge = keyed(r, words, 3);
    r->challenge_tick = tick;
    r->is_challenged = true;
    *challenge = r->challenge;
    return cam_ok;
}

cam_err_t cam_rights_unlock(cam_rights_t *r, uint32_t answer, uint32_t tick)
{
    const bool is_right = r->is_challenged && answer == keyed(r, &r->challenge, 1);
    r->is_challenged = false;
    if (!is_right) {
        return cam_err_unlock;
    }
    unlock(r, cam_level_challenge, tick);
    return cam_ok;
}

/// Turning the key on unlocks the level for the present commander; turning it off locks it.
static void watch_key(cam_rights_t *r, uint32_t inputs, uint32_t tick)
{
    const bool was_on = r->is_key_on;
    r->is_key_on = r->port.has_key && (inputs & (uint32_t)hal_in_key) != 0u;
    if (r->is_key_on && !was_on && r->commander != 0u && r->level == cam_level_locked) {
        unlock(r, cam_level_key, tick);
    }
    if (!r->is_key_on && r->level == cam_level_key) {
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
    return r->port.has_key || r->port.n_secret > 0u ? cam_err_locked : cam_err_lock_none;
}

uint32_t cam_rights_level_left_s(const cam_rights_t *r, uint32_t tick)
{
    const uint32_t whole = (uint32_t)cam_rights_level_s * r->tick_hz;
    const uint32_t passed = tick - r->level_tick;
    const bool is_left = r->level != cam_level_locked && passed < whole;
    return is_left ? (whole - passed + r->tick_hz - 1u) / r->tick_hz : 0u;
}
