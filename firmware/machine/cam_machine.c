// SPDX-License-Identifier: Apache-2.0
#include "cam_machine.h"
#include "cam_build.h" // cam_build_config
#include "cam_fix.h"   // cam_is_within
#include "hal/hal.h"   // hal_halt, hal_has_swing
#include <stddef.h>    // NULL
#include <string.h>    // memset

/// Overspeed is a fault this far above the highest feasible speed: room for speed ripple.
enum { overspeed_percent = 1 };

/// Bytes of the table that one poll looks at.
enum { scrub_bytes = 1024 };

/// Header bytes in front of what the image's CRC covers.
enum { scrub_from = 24 };

static uint32_t start_speed(const cam_params_t *params, const cam_table_t *table)
{
    return params->spindle_mrpm > 0 ? (uint32_t)params->spindle_mrpm : table->spindle_mrpm;
}

static cam_feasibility_t judge(const cam_table_t *table, const cam_params_t *params,
                               uint32_t speed_mrpm, uint32_t tick_hz)
{
    cam_params_t there = *params;
    if (!hal_has_swing()) { // whatever was set
        there.swing_speed_mdeg_per_s = 0;
    }
    return table != NULL ? cam_feasible(table, &there, speed_mrpm, tick_hz)
                         : (cam_feasibility_t){.err = cam_err_no_table, .speed_mrpm = speed_mrpm};
}

/// Hand parameters and table over as one. Nothing changes on error.
static cam_err_t hand_over(cam_machine_t *m, const cam_params_t *params, const cam_table_t *table)
{
    cam_config_t *half = cam_config_free_half(&m->core->config);
    if (half == NULL) {
        return cam_err_busy;
    }
    const uint32_t highest_mrpm = judge(table, params, 1, m->tick_hz).highest_mrpm;
    const uint32_t peak_mrpm =
        table != NULL ? cam_feasible_peak(table, highest_mrpm) : highest_mrpm;
    const uint32_t limit_mrpm = peak_mrpm + peak_mrpm / 100u * overspeed_percent;
    const cam_err_t err =
        cam_build_config(half, params, table, limit_mrpm, m->tick_hz, m->clock_hz);
    if (err == cam_ok) {
        m->generation++;
        half->generation = m->generation;
        cam_config_offer(&m->core->config);
    }
    return err;
}

void cam_machine_init(cam_machine_t *m, cam_t *core, uint32_t tick_hz, uint32_t clock_hz)
{
    (void)memset(core, 0, sizeof *core);
    *m = (cam_machine_t){
        .core = core, .params = cam_param_defaults(), .tick_hz = tick_hz, .clock_hz = clock_hz};
    // The tick does not run yet, so both halves are free; defaults fit every tick rate from 500 Hz
    // on, but for the observer, which is slowed to a twentieth of it.
    const int64_t fastest_mHz = (int64_t)tick_hz * 1000 / 20;
    if (m->params.observer_bandwidth_mHz > fastest_mHz) {
        m->params.observer_bandwidth_mHz = (int32_t)fastest_mHz;
    }
    const cam_err_t err = hand_over(m, &m->params, NULL);
    (void)cam_config_take_isr(&core->config);
    if (err != cam_ok) {
        hal_halt("cam_machine_init: defaults do not fit the tick rate");
    }
}

cam_status_t cam_machine_status(const cam_machine_t *m)
{
    return cam_tick_status(m->core);
}

/// @return whether the interrupt has yet to carry out the last request, which may change the state
static bool is_pending(const cam_machine_t *m, const cam_status_t *status)
{
    return status->request != (m->n_requests & 0xFFFFFFu);
}

static cam_err_t post(cam_machine_t *m, const cam_status_t *status, cam_request_t request)
{
    if (is_pending(m, status)) {
        return cam_err_busy;
    }
    m->n_requests++;
    atomic_store_explicit(&m->core->request, m->n_requests << 8 | (uint32_t)request,
                          memory_order_release);
    return cam_ok;
}

/// A damaged table is no longer there; while enabled the interrupt retracts.
static void report_damage(cam_machine_t *m)
{
    const cam_status_t status = cam_machine_status(m);
    const bool is_idle = !is_pending(m, &status) &&
                         (status.state == cam_state_off || status.state == cam_state_fault);
    if (is_idle || post(m, &status, cam_request_table_fault) == cam_ok) {
        m->has_table = false;
    } // else the next round of the check finds it again
}

cam_err_t cam_machine_select_table(cam_machine_t *m, const void *image, size_t size)
{
    const cam_status_t status = cam_machine_status(m);
    cam_table_t table;
    cam_err_t err = cam_table_check(image, size, &table);
    if (err != cam_ok) {
        if (m->has_table && image == m->table.image) { // overwritten where it is read
            report_damage(m);
        }
        return err;
    }
    // A table for the other sense of rotation changes the angle: only before homing.
    const bool is_same_sense = m->has_table && table.direction == m->table.direction;
    if (is_pending(m, &status)) {
        return cam_err_busy;
    }
    if (status.state != cam_state_off && !(status.state == cam_state_ready && is_same_sense)) {
        return cam_err_state;
    }
    if (status.state == cam_state_ready) { // the spindle turns: it takes the table's speed at once
        err = judge(&table, &m->params, start_speed(&m->params, &table), m->tick_hz).err;
        if (err != cam_ok) {
            return err;
        }
    }
    err = hand_over(m, &m->params, &table);
    if (err == cam_ok) {
        m->table = table;
        m->has_table = true;
        m->scrub_at = 0;
    }
    return err;
}

/// What of the parameters may change in a state.
static bool may_change(cam_param_id_t id, cam_state_t state)
{
    switch (state) {
    case cam_state_off:
        return true;
    case cam_state_ready:
        return id != cam_param_counts_per_turn && id != cam_param_encoder_sign &&
               id != cam_param_index_offset_udeg && id != cam_param_observer_bandwidth_mHz &&
               id != cam_param_z_is_measured && id != cam_param_k1_ns && id != cam_param_k2_us2;
    case cam_state_engaging:
    case cam_state_cutting:
    case cam_state_disengaging:
        return id == cam_param_phase_udeg || id == cam_param_amplitude_ppm;
    case cam_state_homing:
    case cam_state_fault:
    case cam_n_states:
        break;
    }
    return false;
}

cam_err_t cam_machine_set_param(cam_machine_t *m, cam_param_id_t id, int32_t value)
{
    const cam_status_t status = cam_machine_status(m);
    cam_params_t params = m->params;
    cam_err_t err = cam_param_set(&params, id, value);
    if (err != cam_ok) {
        return err;
    }
    if (is_pending(m, &status)) {
        return cam_err_busy;
    }
    if (!may_change(id, status.state)) {
        return cam_err_param_state;
    }
    if (status.state != cam_state_off && m->has_table) {
        err = judge(&m->table, &params, start_speed(&params, &m->table), m->tick_hz).err;
    }
    if (err == cam_ok) {
        err = hand_over(m, &params, m->has_table ? &m->table : NULL);
    }
    if (err == cam_ok) {
        m->params = params;
    }
    return err;
}

cam_feasibility_t cam_machine_feasibility(const cam_machine_t *m, uint32_t speed_mrpm)
{
    const uint32_t speed = speed_mrpm > 0u ? speed_mrpm : start_speed(&m->params, &m->table);
    return judge(m->has_table ? &m->table : NULL, &m->params, speed, m->tick_hz);
}

static cam_err_t post_if(cam_machine_t *m, const cam_status_t *status, bool is_allowed,
                         cam_request_t request)
{
    return is_allowed ? post(m, status, request) : cam_err_state;
}

/// Inputs, and U: commands stay in its stroke, so that it would jump to the edge from outside.
static cam_err_t check_drives(const cam_params_t *params, const cam_status_t *status)
{
    if ((status->inputs & hal_in_estop) != 0u) {
        return cam_err_estop;
    }
    if ((status->inputs & hal_in_drive_ready) == 0u) {
        return cam_err_drive;
    }
    if ((status->inputs & hal_in_bus_lost) != 0u) {
        return cam_err_bus;
    }
    return cam_is_within(status->u_actual_nm, params->u_stroke_nm / 2) ? cam_ok : cam_err_u_place;
}

cam_err_t cam_machine_enable(cam_machine_t *m)
{
    const cam_status_t status = cam_machine_status(m);
    cam_err_t err = status.state == cam_state_off ? cam_ok : cam_err_state;
    if (err == cam_ok) {
        err = cam_machine_feasibility(m, 0).err;
    }
    if (err == cam_ok) {
        err = check_drives(&m->params, &status);
    }
    return err == cam_ok ? post(m, &status, cam_request_enable) : err;
}

cam_err_t cam_machine_disable(cam_machine_t *m)
{
    const cam_status_t status = cam_machine_status(m);
    return post_if(m, &status, status.state == cam_state_homing || status.state == cam_state_ready,
                   cam_request_disable);
}

cam_err_t cam_machine_home(cam_machine_t *m)
{
    const cam_status_t status = cam_machine_status(m);
    if (status.state != cam_state_ready) {
        return cam_machine_enable(m);
    }
    const cam_err_t err = cam_machine_disable(m);
    m->homes_again = err == cam_ok;
    return err;
}

/// Behind the disable of cam_machine_home(). Who interferes, a fault too, ends it.
static void home_again(cam_machine_t *m)
{
    const cam_status_t status = cam_machine_status(m);
    if (!is_pending(m, &status)) {
        m->homes_again = status.state == cam_state_off && cam_machine_enable(m) == cam_err_busy;
    }
}

cam_err_t cam_machine_may_exchange(const cam_machine_t *m)
{
    const cam_status_t status = cam_machine_status(m);
    if (is_pending(m, &status) || status.config != m->generation || m->homes_again) {
        return cam_err_busy;
    }
    return status.state == cam_state_off ? cam_ok : cam_err_state;
}

cam_err_t cam_machine_start(cam_machine_t *m)
{
    const cam_status_t status = cam_machine_status(m);
    if (status.state != cam_state_ready) {
        return cam_err_state;
    }
    const cam_err_t err = cam_machine_feasibility(m, 0).err;
    return err == cam_ok ? post(m, &status, cam_request_start) : err;
}

cam_err_t cam_machine_stop(cam_machine_t *m)
{
    const cam_status_t status = cam_machine_status(m);
    return post_if(m, &status,
                   status.state == cam_state_engaging || status.state == cam_state_cutting,
                   cam_request_stop);
}

cam_err_t cam_machine_reset(cam_machine_t *m)
{
    const cam_status_t status = cam_machine_status(m);
    return post_if(m, &status, status.state == cam_state_fault && status.is_retracted,
                   cam_request_reset);
}

void cam_machine_poll(cam_machine_t *m)
{
    if (m->homes_again) {
        home_again(m);
    }
    if (!m->has_table) {
        return;
    }
    const uint8_t *bytes = (const uint8_t *)m->table.image;
    if (m->scrub_at == 0u) {
        m->scrub_at = scrub_from;
        m->scrub_crc = 0;
    }
    const uint32_t left = m->table.image_size - m->scrub_at;
    const uint32_t n = left < scrub_bytes ? left : scrub_bytes;
    m->scrub_crc = cam_crc32(m->scrub_crc, bytes + m->scrub_at, n);
    m->scrub_at += n;
    if (m->scrub_at == m->table.image_size) {
        m->scrub_at = 0;
        if (m->scrub_crc != m->table.crc32) {
            report_damage(m);
        }
    }
}
