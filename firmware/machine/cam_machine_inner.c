// SPDX-License-Identifier: Apache-2.0
#include "cam_machine_inner.h"
#include "cam_feasible.h" // cam_feasible_highest_mrpm
#include "cam_build.h"    // cam_build_config, cam_build_origin
#include "cam_fix.h"      // cam_abs_i64
#include <stdatomic.h>    // atomic_store_explicit
#include <stddef.h>       // NULL

enum {
    overspeed_percent = 1, ///< margin above the highest feasible speed, for speed ripple
    late_turns = 8,        ///< from the first turn of the ripple's mean to the use of that mean
};

bool cam_machine_is_carried_out(const cam_machine_t *m, const cam_status_t *status)
{
    return status->request == (m->n_requests & 0xFFFFFFu);
}

bool cam_machine_is_pending(const cam_machine_t *m, const cam_status_t *status)
{
    const cam_identify_phase_t phase = m->identify.phase;
    return !cam_machine_is_carried_out(m, status) ||
           (phase != cam_identify_none && phase != cam_identify_runs);
}

void cam_machine_request(cam_machine_t *m, cam_request_t request)
{
    m->n_requests++;
    atomic_store_explicit(&m->core->request, m->n_requests << 8 | (uint32_t)request,
                          memory_order_release);
}

cam_err_t cam_machine_post(cam_machine_t *m, const cam_status_t *status, cam_request_t request)
{
    if (cam_machine_is_pending(m, status)) {
        return cam_err_busy;
    }
    cam_machine_request(m, request);
    return cam_ok;
}

cam_err_t cam_machine_judge(cam_machine_t *m, const cam_params_t *params, const cam_table_t *table)
{
    const cam_refusal_t found = cam_pass_check(table, params, m->tick_hz);
    m->refusal = found.err != cam_ok ? found : m->refusal;
    return found.err;
}

uint32_t cam_machine_highest_mrpm(const cam_machine_t *m)
{
    return m->has_table ? cam_pass_highest_mrpm(&m->table, &m->params, m->tick_hz) : 0u;
}

cam_refusal_t cam_machine_feasibility(const cam_machine_t *m)
{
    if (!m->has_table) {
        return (cam_refusal_t){.err = cam_err_no_table,
                               .param = cam_n_params,
                               .speed_mrpm = (uint32_t)m->params.spindle_mrpm};
    }
    const cam_refusal_t found = cam_pass_check(&m->table, &m->params, m->tick_hz);
    return found.err != cam_ok ? found
                               : cam_pass_feasibility(&m->table, &m->params, m->tick_hz, m->pass);
}

/// Let a start wait for a steady spindle, and without a rehearsal until a ripple is in force.
static void set_steady(cam_config_t *half, const cam_machine_t *m, const cam_params_t *params)
{
    const cam_play_config_t *play = &half->play;
    const bool is_uniform = play->table != NULL && play->table->speed.knots == NULL;
    const bool is_fast =
        (uint32_t)cam_abs_i64(play->spindle_mrpm) >= cam_machine_ripple_from_mrpm(params);
    const bool is_in_force =
        m->ilc.ripple.n_mean > 0u && (m->ilc.blending & cam_ilc_blend_ripple) == 0u;
    const bool waits = is_uniform && is_fast && play->rehearse_q32 == 0 &&
                       params->ripple_turns > 0 && !is_in_force;
    half->play.steady_turns = waits ? (uint32_t)params->ripple_turns + (uint32_t)late_turns : 1u;
}

void cam_machine_offer_copy(cam_machine_t *m)
{
    cam_config_t *half = cam_config_free_half(&m->core->config);
    set_steady(half, m, &m->params);
    m->generation++;
    half->generation = m->generation;
    cam_config_learn(half);
    cam_config_offer(&m->core->config);
}

/// @return [nm] upper end of X's travel in counts of the port
static int32_t x_high_nm(const cam_machine_t *m, const cam_params_t *params)
{
    const bool is_found = (m->offsets.known >> (uint32_t)hal_axis_x & 1u) != 0u;
    const bool is_known = is_found || params->x_home == 0;
    return cam_offsets_travel(&m->offsets, params, hal_axis_x, is_known).high_nm;
}

cam_err_t cam_machine_hand_over(cam_machine_t *m, const cam_params_t *params,
                                const cam_table_t *table, uint32_t pass)
{
    cam_config_t *half = cam_config_free_half(&m->core->config);
    if (half == NULL || m->identify.phase != cam_identify_none) {
        return cam_err_busy; // a wave keeps its configuration
    }
    // The overspeed limit follows from the highest feasible speed.
    const cam_params_t here = cam_pass_params(params, table, pass);
    const uint32_t mean_mrpm =
        table != NULL ? cam_feasible_highest_mrpm(table, &here, m->tick_hz) : 0u;
    const uint32_t peak_mrpm = table != NULL ? cam_feasible_peak_mrpm(table, mean_mrpm) : 0u;
    const uint32_t limit_mrpm = peak_mrpm + peak_mrpm / 100u * overspeed_percent;
    const cam_refusal_t refusal =
        cam_build_config(half, &here, table, limit_mrpm, m->tick_hz, m->clock_hz);
    if (refusal.err != cam_ok) {
        m->refusal = refusal;
        return refusal.err;
    }
    cam_build_origin(half, cam_offsets_origin_nm(&m->offsets, params, hal_axis_x),
                     cam_offsets_origin_nm(&m->offsets, params, hal_axis_z));
    const cam_config_t *last = cam_machine_newest_config(m);
    half->play.x_high_nm = x_high_nm(m, params);
    if (last != NULL) {
        half->learned = last->learned;
        half->play.jog.order = last->play.jog.order;
    }
    cam_config_learn(half);
    set_steady(half, m, params);
    half->play.acknowledge = cam_machine_acknowledge_config(m);
    if (m->is_held) {
        half->play.feed_rate_q30 = 0;
    }
    m->is_rate_due = false;
    m->generation++;
    m->pass = pass;
    m->limit_mrpm = limit_mrpm;
    half->generation = m->generation;
    cam_config_offer(&m->core->config);
    return cam_ok;
}
