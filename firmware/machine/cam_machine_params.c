// SPDX-License-Identifier: Apache-2.0
// Parameter changes: which are allowed in which state, staged changes, kept parameters.
#include "cam_machine_inner.h"
#include "cam_feasible.h" // cam_derived_limits_most
#include "cam_fix.h"      // cam_is_within, cam_clamp_i32
#include "hal/hal.h"      // hal_params_kept
#include <stddef.h>       // NULL
#include <string.h>       // memcmp

/// No version of the parameters has this number.
#define NO_VERSION UINT32_MAX

static bool may_change(cam_param_id_t id, cam_state_t state)
{
    if (state == cam_state_ready || state == cam_state_manual) {
        return !cam_param_has(id, cam_flag_off);
    }
    if (cam_state_is_in_work(state)) {
        return cam_param_has(id, cam_flag_cut);
    }
    return state == cam_state_off;
}

static bool is_change(const cam_params_t *from, const cam_params_t *to, cam_param_id_t id)
{
    return cam_param_get(from, id) != cam_param_get(to, id);
}

static cam_err_t refuse(cam_machine_t *m, cam_err_t err, cam_param_id_t id, int64_t needed,
                        int64_t limit)
{
    m->refusal = cam_refusal_of(err, id, needed, limit);
    return err;
}

/// A parameter limits the trim, so that a typing error does not spoil a part. During a pass X
/// applies the trim at once and must stay within its travel.
static cam_err_t check_trim(cam_machine_t *m, const cam_params_t *params,
                            const cam_status_t *status)
{
    if (!cam_is_within(params->x_trim_nm, params->x_trim_limit_nm)) {
        return refuse(m, cam_err_trim_limit, cam_param_x_trim_nm, cam_abs_i64(params->x_trim_nm),
                      params->x_trim_limit_nm);
    }
    const bool is_safe = !m->has_table || !cam_state_is_in_work(status->state) ||
                         cam_machine_is_x_in_travel(m, status, params->x_trim_nm);
    return is_safe ? cam_ok : cam_err_travel;
}

/// While enabled, U must be within the new stroke, or limiting its set-point would cause a step.
static cam_err_t check_stroke(cam_machine_t *m, const cam_params_t *params,
                              const cam_status_t *status)
{
    const int32_t half_nm = params->u_stroke_nm / 2;
    if (status->state == cam_state_off || cam_is_within(status->u_set_q6, half_nm * 64)) {
        return cam_ok;
    }
    return refuse(m, cam_err_u_place, cam_param_u_stroke_nm, cam_abs_i64(status->u_set_q6) / 64,
                  half_nm);
}

static cam_err_t check_state(cam_machine_t *m, const cam_params_t *params, cam_param_id_t named,
                             const cam_status_t *status)
{
    const bool is_moving = status->state != cam_state_off && !status->is_u_at_rest;
    for (uint32_t i = 0; i < (uint32_t)cam_n_params; i++) {
        const cam_param_id_t id = (cam_param_id_t)i;
        const bool is_set = id == named || is_change(&m->params, params, id);
        if (is_set && !may_change(id, status->state)) {
            return refuse(m, cam_err_param_state, id, 0, 0);
        }
        if (is_set && is_moving && cam_param_has(id, cam_flag_rest)) {
            return cam_err_busy;
        }
    }
    return cam_ok;
}

/// Refuse changes of locked parameters unless the level allows them.
static cam_err_t check_level(cam_machine_t *m, const cam_params_t *from, const cam_params_t *to,
                             cam_param_id_t named)
{
    const cam_err_t err = cam_rights_check_level(&m->rights);
    for (uint32_t i = 0; err != cam_ok && i < (uint32_t)cam_n_params; i++) {
        const cam_param_id_t id = (cam_param_id_t)i;
        if (!cam_param_has(id, cam_flag_operator) && (id == named || is_change(from, to, id))) {
            return refuse(m, err, id, 0, 0);
        }
    }
    return cam_ok;
}

/// Store parameters that were handed to the interrupt.
static void adopt(cam_machine_t *m, const cam_params_t *params, cam_param_id_t named)
{
    bool is_new = false;
    for (uint32_t i = 0; i < (uint32_t)cam_n_params; i++) {
        const cam_param_id_t id = (cam_param_id_t)i;
        const bool is_changed = is_change(&m->params, params, id);
        is_new = is_new || is_changed;
        if (is_changed || id == named) {
            m->is_in_pass = m->is_in_pass && id != cam_param_pass;
            cam_machine_unlearn(m, id);
        }
    }
    m->params = *params;
    if (is_new) {
        m->version++;
        m->checksum = cam_param_store_checksum(params);
    }
}

/// Apply parameters, all in the same tick.
/// @param named  counts as changed even if its value is the same; cam_n_params: none
static cam_err_t apply(cam_machine_t *m, const cam_params_t *params, cam_param_id_t named)
{
    const cam_status_t status = cam_machine_status(m);
    if (cam_machine_is_pending(m, &status)) {
        return cam_err_busy;
    }
    cam_err_t err = check_level(m, &m->params, params, named);
    err = err == cam_ok ? check_state(m, params, named, &status) : err;
    err = err == cam_ok ? check_stroke(m, params, &status) : err;
    err = err == cam_ok ? check_trim(m, params, &status) : err;
    // An enabled machine applies the change at once, so the result must be feasible.
    const bool is_judged = status.state != cam_state_off && status.state != cam_state_manual;
    if (err == cam_ok && is_judged && m->has_table) {
        err = cam_machine_judge(m, params, &m->table);
    }
    if (err == cam_ok) {
        const cam_table_t *table = m->has_table ? &m->table : NULL;
        const bool begins = named == cam_param_pass || params->pass != m->params.pass;
        const uint32_t pass = begins ? cam_pass_first(params, table) : m->pass;
        err = cam_machine_hand_over(m, params, table, pass);
    }
    if (err == cam_ok) {
        adopt(m, params, named);
    }
    return err;
}

cam_err_t cam_machine_set_param(cam_machine_t *m, cam_param_id_t id, int32_t value)
{
    cam_params_t params = m->params;
    const cam_err_t err = cam_param_set(&params, id, value);
    return err == cam_ok ? apply(m, &params, id) : err;
}

void cam_machine_stage_begin(cam_machine_t *m)
{
    m->staged = m->params;
    m->staged_version = m->version;
}

cam_err_t cam_machine_stage(cam_machine_t *m, cam_param_id_t id, int32_t value)
{
    return m->staged_version != NO_VERSION ? cam_param_set(&m->staged, id, value)
                                           : cam_err_params_begin;
}

cam_err_t cam_machine_stage_commit(cam_machine_t *m)
{
    if (m->staged_version == NO_VERSION) {
        return cam_err_params_begin;
    }
    const bool is_stale = m->staged_version != m->version;
    const cam_err_t err = is_stale ? cam_err_params_stale : apply(m, &m->staged, cam_n_params);
    if (err == cam_ok || is_stale) {
        m->staged_version = NO_VERSION;
    }
    return err;
}

cam_params_t cam_machine_defaults(uint32_t tick_hz)
{
    cam_params_t params = cam_param_defaults();
    if (tick_hz >= (uint32_t)cam_derived_limits_least_hz) {
        params.following_limit_nm = hal_measures_u() ? 0 : params.following_limit_nm; // 0: derived
        cam_param_learn(&params, hal_measures_u()); // also clamps all parameters to their ranges
    }
    // At 500 Hz and above only these defaults may not fit: the bandwidth is limited to a twentieth
    // of the tick rate, the speeds of X and Z by what their outputs support.
    params.observer_bandwidth_mHz =
        cam_derived_limits_usual_mHz(params.observer_bandwidth_mHz, tick_hz);
    params.x_speed_um_per_s = cam_clamp_i32(
        params.x_speed_um_per_s, 0, cam_derived_limits_most(cam_param_x_speed_um_per_s, tick_hz));
    params.z_speed_um_per_s = cam_clamp_i32(
        params.z_speed_um_per_s, 0, cam_derived_limits_most(cam_param_z_speed_um_per_s, tick_hz));
    return params;
}

bool cam_machine_load_params(cam_machine_t *m)
{
    const hal_params_t kept = hal_params_kept();
    cam_params_t params = m->params;
    m->staged_version = NO_VERSION;
    m->checksum = cam_param_store_checksum(&params);
    m->kept = cam_param_store_read(&kept, &params);
    cam_param_forget(&params);
    if (m->kept.err == cam_ok) {
        m->kept.err = cam_machine_hand_over(m, &params, NULL, 0);
    }
    if (m->kept.err != cam_ok) {
        return false;
    }
    m->params = params;
    m->version = m->kept.version;
    m->checksum = cam_param_store_checksum(&params);
    m->kept_checksum = m->checksum;
    return true;
}

/// Keep a text. @return whether the port returns it, too: it will be there at the next power-on
static bool keep_text(const char *text, uint32_t n)
{
    if (!hal_params_keep(text, n)) {
        return false;
    }
    const hal_params_t kept = hal_params_kept();
    return !kept.is_damaged && kept.size == n && memcmp(kept.bytes, text, n) == 0;
}

cam_err_t cam_machine_save_params(cam_machine_t *m)
{
    static char text[cam_param_store_most_bytes];
    cam_params_t params = m->params;
    cam_param_forget(&params);
    cam_err_t err = cam_machine_may_exchange(m);
    if (err == cam_ok && cam_machine_status(m).state != cam_state_off) {
        err = cam_err_state;
    }
    if (err == cam_ok) { // the level must allow these limits and constants at the next power-on
        const hal_params_t kept = hal_params_kept();
        cam_params_t next = cam_machine_defaults(m->tick_hz);
        (void)cam_param_store_read(&kept, &next);
        err = check_level(m, &next, &params, cam_n_params);
    }
    if (err != cam_ok) {
        return err;
    }
    const uint32_t n = cam_param_store_write(text, &params, m->version);
    if (!keep_text(text, n)) {
        return cam_err_params_keep;
    }
    m->kept = (cam_param_store_found_t){.err = cam_ok, .version = m->version};
    m->kept_checksum = cam_param_store_checksum(&params);
    return cam_ok;
}

cam_err_t cam_machine_restore_defaults(cam_machine_t *m)
{
    const cam_params_t params = cam_machine_defaults(m->tick_hz);
    return apply(m, &params, cam_n_params);
}

cam_err_t cam_machine_revert_params(cam_machine_t *m)
{
    const hal_params_t kept = hal_params_kept();
    cam_params_t params = cam_machine_defaults(m->tick_hz);
    const cam_param_store_found_t found = cam_param_store_read(&kept, &params);
    cam_param_forget(&params);
    return found.err == cam_ok ? apply(m, &params, cam_n_params) : found.err;
}

cam_kept_t cam_machine_params_kept(const cam_machine_t *m)
{
    if (m->kept.err == cam_ok) {
        return m->kept_checksum == m->checksum ? cam_kept_same : cam_kept_changed;
    }
    return m->kept.err == cam_err_params_none ? cam_kept_none : cam_kept_damaged;
}
