// SPDX-License-Identifier: Apache-2.0
#include "cam_machine_inner.h"
#include "cam_recorder.h" // cam_blackbox_is_unread
#include "cam_fix.h"      // cam_sat_i32
#include "cam_table.h"    // cam_crc32
#include <stddef.h>       // NULL
#include <string.h>       // memcmp, memcpy

// The wave

static uint8_t *wave_bytes(cam_machine_t *m)
{
    return (uint8_t *)m->scope.words;
}

cam_err_t cam_machine_wave_begin(cam_machine_t *m, uint32_t n_bytes)
{
    cam_identify_t *i = &m->identify;
    if (i->phase != cam_identify_none) {
        return i->phase == cam_identify_runs ? cam_err_state : cam_err_busy;
    }
    if (cam_blackbox_is_unread(&m->scope)) {
        return cam_err_scope_unread;
    }
    if (m->scope.use == cam_scope_user && cam_scope_is_on(&m->scope)) {
        return cam_err_scope_on;
    }
    if (n_bytes % sizeof(int32_t) != 0u || n_bytes < cam_wave_least * sizeof(int32_t)) {
        return cam_err_wave_length;
    }
    const uint32_t n = n_bytes / sizeof(int32_t);
    if (n > m->scope.n_words / 2u) {
        return cam_err_scope_memory;
    }
    cam_scope_reserve(&m->scope, n);
    i->n = 0;
    i->is_force = false;
    i->n_bytes = n_bytes;
    i->received = 0;
    i->is_open = true;
    return cam_ok;
}

cam_err_t cam_machine_wave_block(cam_machine_t *m, uint32_t offset, const uint8_t *bytes,
                                 uint32_t n)
{
    cam_identify_t *i = &m->identify;
    if (!i->is_open || n == 0u || n % sizeof(int32_t) != 0u) {
        return cam_err_download_order;
    }
    if (offset > i->n_bytes || n > i->n_bytes - offset) {
        return cam_err_download_room;
    }
    if (offset + n <= i->received && memcmp(&wave_bytes(m)[offset], bytes, n) == 0) {
        return cam_ok;
    }
    if (offset != i->received) {
        return cam_err_download_order;
    }
    (void)memcpy(&wave_bytes(m)[offset], bytes, n);
    i->received += n;
    return cam_ok;
}

cam_err_t cam_machine_wave_end(cam_machine_t *m, uint32_t crc)
{
    cam_identify_t *i = &m->identify;
    if (!i->is_open) {
        return cam_err_download_order;
    }
    if (i->received < i->n_bytes) {
        return cam_err_download_short;
    }
    i->is_open = false;
    if (cam_crc32(0, wave_bytes(m), i->n_bytes) != crc) {
        return cam_err_download_crc;
    }
    i->n = i->n_bytes / (uint32_t)sizeof(int32_t);
    return cam_ok;
}

// The excitation

static cam_err_t check_moment(const cam_machine_t *m, const cam_status_t *status)
{
    if (cam_machine_is_pending(m, status)) {
        return cam_err_busy;
    }
    if (status->state != cam_state_ready) {
        return cam_err_state;
    }
    if (m->identify.n == 0u) {
        return cam_err_wave_none;
    }
    return cam_blackbox_is_unread(&m->scope) ? cam_err_scope_unread : cam_ok;
}

/// Limit fades and periods together to cam_wave_longest_s.
static cam_verdict_t check_length(const cam_machine_t *m, uint32_t n_periods, uint32_t fade_ticks)
{
    const uint64_t most = (uint64_t)cam_wave_longest_s * m->tick_hz;
    const uint64_t ticks = (uint64_t)n_periods * m->identify.n + 2u * (uint64_t)fade_ticks;
    const bool is_good = n_periods >= 1u && ticks <= most && fade_ticks >= cam_wave_least &&
                         fade_ticks <= cam_wave_longest_fade;
    if (is_good) {
        return (cam_verdict_t){.err = cam_ok};
    }
    return (cam_verdict_t){cam_err_wave_length, cam_sat_i32((int64_t)most)};
}

/// Require half the clearance between tool and work, at every height and at U's innermost sample,
/// or with a force at the end of U's travel.
static cam_verdict_t check_clear(const cam_machine_t *m, const cam_status_t *status,
                                 const cam_config_t *cfg, const cam_wave_range_t *range)
{
    const cam_identify_t *i = &m->identify;
    const int64_t off_nm = (cfg->play.x_clear_q10 >> 10) - cfg->play.x_clearance_nm / 2;
    const int64_t needed_nm =
        off_nm + (i->is_force ? cfg->force.travel_nm : i->place_nm + range->high_nm);
    if (status->x_actual_nm >= needed_nm) {
        return (cam_verdict_t){.err = cam_ok};
    }
    return (cam_verdict_t){cam_err_wave_clear, cam_sat_i32(needed_nm)};
}

/// @return [nm] accepted following error during the wave; a force moves U over its travel
static int64_t following_nm(const cam_machine_t *m, const cam_config_t *cfg,
                            const cam_wave_range_t *range)
{
    return m->identify.is_force ? INT64_C(2) * cfg->force.travel_nm
                                : cfg->guard.following_nm + cam_wave_peak_nm(range);
}

/// Offer the interrupt the configuration in force with another excitation.
/// @param following_nm  [nm] limit of the following error
/// @return              false until the interrupt has taken the previous configuration
static bool offer(cam_machine_t *m, const cam_excite_config_t *excite, int32_t following_nm)
{
    cam_config_t *copy = cam_config_copy(&m->core->config);
    if (copy == NULL) {
        return false;
    }
    copy->play.excite = *excite;
    copy->guard.following_nm = following_nm;
    cam_machine_offer_copy(m);
    return true;
}

/// Arm the recorder and offer the wave.
static cam_err_t offer_wave(cam_machine_t *m, const cam_status_t *status,
                            const cam_excite_config_t *excite, int64_t following_nm)
{
    cam_identify_t *i = &m->identify;
    cam_scope_plan_t plan = m->scope.set;
    plan.from_state = cam_state_identifying;
    plan.before = 0;
    plan.trigger.kind = cam_trigger_now;
    const cam_err_t err = cam_scope_begin(&m->scope, &plan, cam_scope_user, 0, status->tick);
    if (err != cam_ok) {
        return err;
    }
    if (!offer(m, excite, cam_sat_i32(following_nm))) {
        cam_scope_stop(&m->scope);
        return cam_err_busy;
    }
    i->phase = cam_identify_offered;
    i->excited = cam_excited_runs;
    i->alive_tick = status->tick;
    i->disables = false;
    return cam_ok;
}

cam_verdict_t cam_machine_excite(cam_machine_t *m, uint32_t n_periods, uint32_t fade_ticks)
{
    const cam_status_t status = cam_machine_status(m);
    cam_verdict_t verdict = {.err = check_moment(m, &status)};
    verdict = verdict.err == cam_ok ? check_length(m, n_periods, fade_ticks) : verdict;
    if (verdict.err != cam_ok) {
        return verdict;
    }
    const cam_config_t *cfg = cam_machine_newest_config(m);
    const cam_wave_range_t range = cam_wave_range(m->scope.words, m->identify.n);
    const cam_motion_limits_t fade = cam_wave_fade(fade_ticks);
    const uint32_t n_fall = cam_wave_fall_ticks(&fade); // the rise takes as many
    const uint32_t n = m->identify.n;
    const cam_excite_config_t excite = {
        .wave = m->scope.words,
        .n = n,
        .first = (n - n_fall % n) % n, // the first period at full gain begins with sample 0
        .n_play = n_periods * n + n_fall,
        .fade = fade,
        .place_q10 = (int64_t)m->identify.place_nm * 1024,
        .is_force = m->identify.is_force,
    };
    verdict = cam_wave_judge(&range, &fade, excite.is_force, m->identify.place_nm, cfg, m->tick_hz);
    verdict = verdict.err == cam_ok ? check_clear(m, &status, cfg, &range) : verdict;
    if (verdict.err != cam_ok) {
        return verdict;
    }
    m->identify.following_nm = cfg->guard.following_nm;
    m->identify.n_fall = excite.is_force ? 0u : n_fall;
    verdict.err = offer_wave(m, &status, &excite, following_nm(m, cfg, &range));
    return verdict;
}

// The sequence

/// Stop when no sign of life comes; note the result at the end.
static void watch(cam_machine_t *m, const cam_status_t *status)
{
    cam_identify_t *i = &m->identify;
    const uint32_t patience_ticks = m->tick_hz / 1000u * (uint32_t)cam_identify_patience_ms;
    if (status->state == cam_state_identifying) {
        i->phase = cam_identify_runs;
        if (i->excited == cam_excited_runs && status->tick - i->alive_tick > patience_ticks) {
            i->excited = cam_excited_silent;
            cam_machine_request(m, cam_request_stop);
        }
        return;
    }
    i->phase = cam_identify_ends;
    if (status->state != cam_state_ready) {
        i->excited = cam_excited_fault;
        return;
    }
    if (i->excited == cam_excited_runs) { // not stopped early, which has noted its reason
        i->excited = cam_excited_done;
    }
}

/// Restore the limit of the following error, then disable if requested.
static void end(cam_machine_t *m)
{
    static const cam_excite_config_t nothing = {0};
    if (offer(m, &nothing, m->identify.following_nm)) {
        m->identify.phase = cam_identify_none;
        const cam_err_t err = m->identify.disables ? cam_machine_disable(m) : cam_ok;
        (void)err; // refused after a fault, whose retract disables as well
    }
}

void cam_machine_identify_poll(cam_machine_t *m)
{
    cam_identify_t *i = &m->identify;
    if (i->phase == cam_identify_none) {
        return;
    }
    const cam_status_t status = cam_machine_status(m);
    if (!cam_machine_is_carried_out(m, &status)) {
        return;
    }
    if (i->phase == cam_identify_offered) {
        if (status.config == m->generation) { // the interrupt has taken the wave
            cam_machine_request(m, cam_request_identify);
            i->phase = cam_identify_requested;
        }
    } else if (i->phase == cam_identify_ends) {
        end(m);
    } else {
        watch(m, &status);
    }
}

cam_err_t cam_machine_identify_stop(cam_machine_t *m, bool disables)
{
    cam_identify_t *i = &m->identify;
    const cam_status_t status = cam_machine_status(m);
    if (!cam_machine_is_carried_out(m, &status) || i->phase != cam_identify_runs) {
        return cam_err_busy;
    }
    i->disables = i->disables || disables;
    if (i->excited == cam_excited_runs) {
        i->excited = cam_excited_stopped;
        cam_machine_request(m, cam_request_stop);
    }
    return cam_ok;
}
