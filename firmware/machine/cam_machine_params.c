// SPDX-License-Identifier: Apache-2.0
// What parameters may change when, one or all of them at once, and how they are kept.
#include "cam_derived_limits.h" // cam_derived_limits_most
#include "cam_fix.h"            // cam_is_within
#include "cam_gains.h"          // cam_gains_check
#include "cam_machine_jog.h"    // cam_machine_is_x_in_travel
#include "cam_machine_inner.h"  // cam_machine_judge, cam_machine_hand_over
#include "cam_pass.h"           // cam_pass_first
#include "hal/hal.h"            // hal_params_kept
#include <stddef.h>             // NULL

/// A version that no parameters have.
#define NO_VERSION UINT32_MAX

/// @return whether a parameter may change in a state
static bool may_change(cam_param_id_t id, cam_state_t state)
{
    switch (state) {
    case cam_state_off:
        return true;
    case cam_state_ready:
    case cam_state_manual:
        return id != cam_param_counts_per_turn && id != cam_param_encoder_sign &&
               id != cam_param_index_offset_udeg && id != cam_param_observer_bandwidth_mHz &&
               id != cam_param_z_is_measured;
    case cam_state_engaging:
    case cam_state_cutting:
    case cam_state_disengaging:
    case cam_state_rehearsing:
    case cam_state_holding:
        return id == cam_param_phase_udeg || id == cam_param_amplitude_ppm ||
               id == cam_param_x_trim_nm || id == cam_param_feed_override_ppm ||
               id == cam_param_spindle_override_ppm;
    case cam_state_homing:
    case cam_state_fault:
    case cam_state_identifying:
    case cam_n_states:
        break;
    }
    return false;
}

/// U's feed-forward adds nothing to its command while U stands, so it may change without a step;
/// and a U that stands exceeds none of its limits, whatever they become.
static bool needs_rest(cam_param_id_t id)
{
    return id == cam_param_k1_ns || id == cam_param_k2_us2 || id == cam_param_u_stroke_nm ||
           id == cam_param_u_speed_um_per_s || id == cam_param_u_acceleration_mm_per_s2 ||
           id == cam_param_u_jerk_m_per_s3;
}

/// @return whether a parameter is named, or has another value than in force
static bool is_touched(const cam_machine_t *m, const cam_params_t *params, cam_param_id_t named,
                       uint32_t id)
{
    return id == (uint32_t)named || cam_param_get(&m->params, (cam_param_id_t)id) !=
                                        cam_param_get(params, (cam_param_id_t)id);
}

static cam_err_t refuse_change(cam_machine_t *m, cam_err_t err, uint32_t id)
{
    m->refusal = (cam_refusal_t){.why.err = err, .param = (cam_param_id_t)id};
    return err;
}

/// A trim is bounded by a parameter of its own, so that a slip of the hand does not spoil a part.
/// While X is on its way it takes a trim at once, and must not leave its travel by it.
static cam_err_t check_trim(cam_machine_t *m, const cam_params_t *params,
                            const cam_status_t *status)
{
    if (cam_is_within(params->x_trim_nm, params->x_trim_limit_nm)) {
        const bool is_safe = !m->has_table || !cam_state_is_in_work(status->state) ||
                             cam_machine_is_x_in_travel(m, status, params->x_trim_nm);
        return is_safe ? cam_ok : cam_err_travel;
    }
    (void)refuse_change(m, cam_err_trim_limit, (uint32_t)cam_param_x_trim_nm);
    m->refusal.why.needed = cam_abs_i64(params->x_trim_nm);
    m->refusal.why.limit = params->x_trim_limit_nm;
    return cam_err_trim_limit;
}

/// Enabled, U must stand within its stroke, or it could not move without a leap.
static cam_err_t check_stroke(cam_machine_t *m, const cam_params_t *params,
                              const cam_status_t *status)
{
    const int32_t half_nm = params->u_stroke_nm / 2;
    if (status->state == cam_state_off || cam_is_within(status->u_set_q6, half_nm * 64)) {
        return cam_ok;
    }
    (void)refuse_change(m, cam_err_u_place, (uint32_t)cam_param_u_stroke_nm);
    m->refusal.why.needed = cam_abs_i64(status->u_set_q6) / 64;
    m->refusal.why.limit = half_nm;
    return cam_err_u_place;
}

/// Check whether the state allows all changes.
static cam_err_t check_state(cam_machine_t *m, const cam_params_t *params, cam_param_id_t named,
                             const cam_status_t *status)
{
    for (uint32_t id = 0; id < (uint32_t)cam_n_params; id++) {
        if (!is_touched(m, params, named, id)) {
            continue;
        }
        if (!may_change((cam_param_id_t)id, status->state)) {
            return refuse_change(m, cam_err_param_state, id);
        }
        if (needs_rest((cam_param_id_t)id) && status->state != cam_state_off &&
            !status->is_u_at_rest) {
            return cam_err_busy;
        }
    }
    return cam_ok;
}

/// Keep which parameter does not fit tick or outputs, with the most that does. A lead that fits by
/// itself is too long together with the latency of U's scale.
static void explain_fit(cam_machine_t *m, const cam_params_t *params, cam_err_t err)
{
    uint32_t id = 0;
    while (id < (uint32_t)cam_n_params &&
           cam_param_get(params, (cam_param_id_t)id) <=
               cam_derived_limits_most((cam_param_id_t)id, m->tick_hz)) {
        id++;
    }
    const bool is_sum = id == (uint32_t)cam_n_params;
    const cam_param_id_t which = is_sum ? cam_param_lead_ns : (cam_param_id_t)id;
    m->refusal = (cam_refusal_t){
        .why.err = err,
        .why.needed =
            (int64_t)cam_param_get(params, which) + (is_sum ? params->u_scale_latency_ns : 0),
        .why.limit = cam_derived_limits_most(which, m->tick_hz),
        .param = which,
    };
}

/// Check whether the level allows all changes.
static cam_err_t check_level(cam_machine_t *m, const cam_params_t *params, cam_param_id_t named)
{
    const cam_err_t err = cam_rights_check_level(&m->rights);
    for (uint32_t id = 0; id < (uint32_t)cam_n_params && err != cam_ok; id++) {
        if (cam_param_is_locked((cam_param_id_t)id) && is_touched(m, params, named, id)) {
            return refuse_change(m, err, id);
        }
    }
    return cam_ok;
}

/// Keep which gain or jerk is refused, with the largest gain or the least jerk that is not.
static void explain_gains(cam_machine_t *m, const cam_params_t *params)
{
    m->refusal = (cam_refusal_t){0};
    m->refusal.why.err = cam_gains_check(params, m->tick_hz, &m->refusal.param);
    m->refusal.why.needed = cam_param_get(params, m->refusal.param);
    m->refusal.why.limit = cam_gains_bound(params, m->refusal.param, m->tick_hz);
}

/// Take over parameters that have been handed to the interrupt.
static void adopt(cam_machine_t *m, const cam_params_t *params, cam_param_id_t named)
{
    const cam_params_t before = m->params;
    bool is_changed = false;
    m->params = *params;
    for (uint32_t id = 0; id < (uint32_t)cam_n_params; id++) {
        const cam_param_id_t which = (cam_param_id_t)id;
        const bool differs = cam_param_get(&before, which) != cam_param_get(params, which);
        is_changed = is_changed || differs;
        if (differs || which == named) {
            m->is_in_pass = m->is_in_pass && which != cam_param_pass;
            cam_machine_unlearn(m, which);
        }
    }
    if (is_changed) {
        m->version++;
        m->checksum = cam_param_store_checksum(params);
    }
}

/// Bring parameters into force, all of them in the same tick.
/// @param named  a parameter that counts as changed even if its value is the same; cam_n_params:
///               none
static cam_err_t apply(cam_machine_t *m, const cam_params_t *params, cam_param_id_t named)
{
    const cam_status_t status = cam_machine_status(m);
    if (cam_machine_is_pending(m, &status)) {
        return cam_err_busy;
    }
    cam_err_t err = check_level(m, params, named);
    if (err == cam_ok) {
        err = check_state(m, params, named, &status);
    }
    if (err == cam_ok) {
        err = check_stroke(m, params, &status);
    }
    if (err == cam_ok) {
        err = check_trim(m, params, &status);
    }
    // Enabled, the machine takes a changed parameter at once, so what it leads to must be feasible.
    const bool is_judged = status.state != cam_state_off && status.state != cam_state_manual;
    if (err == cam_ok && is_judged && m->has_table) {
        err = cam_machine_judge(m, params, &m->table);
    }
    if (err == cam_ok) {
        const cam_table_t *table = m->has_table ? &m->table : NULL;
        const bool begins = is_touched(m, params, named, (uint32_t)cam_param_pass);
        const uint32_t pass = begins ? cam_pass_first(params, table) : m->pass;
        err = cam_machine_hand_over(m, params, table, pass);
    }
    if (err == cam_err_param_tick || err == cam_err_param_output) {
        explain_fit(m, params, err);
    }
    if (err == cam_err_gain || err == cam_err_jerk) {
        explain_gains(m, params);
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

static void limit_to(int32_t *value, int32_t most)
{
    *value = *value < most ? *value : most;
}

cam_params_t cam_machine_defaults(uint32_t tick_hz)
{
    cam_params_t params = cam_param_defaults();
    if (hal_measures_u() && tick_hz >= (uint32_t)cam_derived_limits_least_hz) {
        params.following_limit_nm = 0; // derived from the part
        cam_param_learn(&params);      // and all of them led into their ranges
    }
    // The defaults fit every tick rate from 500 Hz on but for the observer's bandwidth, which is
    // limited to a twentieth of the rate, and the speeds of X and Z to what their outputs pass on.
    params.observer_bandwidth_mHz =
        cam_derived_limits_usual_mHz(params.observer_bandwidth_mHz, tick_hz);
    limit_to(&params.x_speed_um_per_s,
             cam_derived_limits_most(cam_param_x_speed_um_per_s, tick_hz));
    limit_to(&params.z_speed_um_per_s,
             cam_derived_limits_most(cam_param_z_speed_um_per_s, tick_hz));
    return params;
}

/// An override belongs to the part that is cut under somebody's eyes: a start has none.
static void forget_overrides(cam_params_t *params)
{
    params->feed_override_ppm = cam_param_info(cam_param_feed_override_ppm)->def;
    params->spindle_override_ppm = cam_param_info(cam_param_spindle_override_ppm)->def;
}

bool cam_machine_load_params(cam_machine_t *m)
{
    const hal_params_t kept = hal_params_kept();
    cam_params_t params = m->params;
    m->staged_version = NO_VERSION;
    m->checksum = cam_param_store_checksum(&params);
    m->kept = cam_param_store_read(&kept, &params);
    forget_overrides(&params);
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

/// Check whether the level allows the next start to begin with other limits and constants than
/// those that are kept.
static cam_err_t check_keep(cam_machine_t *m, const cam_params_t *params)
{
    const hal_params_t kept = hal_params_kept();
    cam_params_t next = cam_machine_defaults(m->tick_hz);
    (void)cam_param_store_read(&kept, &next);
    const cam_err_t err = cam_rights_check_level(&m->rights);
    for (uint32_t i = 0; i < (uint32_t)cam_n_params && err != cam_ok; i++) {
        const cam_param_id_t id = (cam_param_id_t)i;
        if (cam_param_is_locked(id) && cam_param_get(&next, id) != cam_param_get(params, id)) {
            return refuse_change(m, err, i);
        }
    }
    return cam_ok;
}

cam_err_t cam_machine_save_params(cam_machine_t *m)
{
    static char text[cam_param_store_most_bytes];
    cam_params_t params = m->params;
    forget_overrides(&params);
    cam_err_t err = cam_machine_may_keep(m);
    if (err == cam_ok) {
        err = check_keep(m, &params);
    }
    if (err != cam_ok) {
        return err;
    }
    const uint32_t n = cam_param_store_write(text, &params, m->version);
    if (!hal_params_keep(text, n)) {
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
    forget_overrides(&params);
    return found.err == cam_ok ? apply(m, &params, cam_n_params) : found.err;
}

/// @return where the parameters in force stand
static cam_kept_t kept_of(const cam_machine_t *m)
{
    if (m->kept.err == cam_ok) {
        return m->kept_checksum == m->checksum ? cam_kept_same : cam_kept_changed;
    }
    return m->kept.err == cam_err_params_none ? cam_kept_none : cam_kept_damaged;
}

cam_params_status_t cam_machine_params_status(const cam_machine_t *m)
{
    return (cam_params_status_t){
        .version = m->version, .checksum = m->checksum, .kept = kept_of(m)};
}
