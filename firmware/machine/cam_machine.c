// SPDX-License-Identifier: Apache-2.0
#include "cam_machine_inner.h"
#include "cam_build.h" // cam_build_speed_q32
#include "cam_fix.h"   // cam_is_within
#include "hal/hal.h"   // hal_halt, hal_scope_memory
#include <stddef.h>    // NULL
#include <string.h>    // memset

/// [bytes] checked per call of cam_machine_poll(); offset where the image's CRC begins
/// (TABLE_FORMAT.md).
enum { check_bytes = 1024, check_from = 24 };

/// Turns after which those of a steady spindle have agreed, however slow it is.
enum { least_turns = 4 };

void cam_machine_init(cam_machine_t *m, cam_t *core, uint32_t tick_hz, uint32_t clock_hz)
{
    (void)memset(core, 0, sizeof *core);
    *m = (cam_machine_t){.core = core,
                         .params = cam_machine_defaults(tick_hz),
                         .tick_hz = tick_hz,
                         .clock_hz = clock_hz};
    const hal_operator_t people = hal_operator();
    cam_rights_init(&m->rights, &people, tick_hz);
    cam_scope_init(&m->scope, hal_scope_memory(), tick_hz);
    cam_ilc_init(&m->ilc);
    // The tick does not run yet, so the interrupt's side may be written here.
    const bool is_kept = cam_machine_load_params(m);
    const cam_err_t err = is_kept ? cam_ok : cam_machine_hand_over(m, &m->params, NULL, 0);
    (void)cam_config_take_isr(&core->config);
    if (err != cam_ok) {
        hal_halt("cam_machine_init: defaults do not fit the tick rate");
    }
}

cam_status_t cam_machine_status(const cam_machine_t *m)
{
    return cam_status_read(m->core);
}

/// Stop using a damaged table. While the drives are enabled, the interrupt raises the fault `table`
/// and retracts; off and fault need no request.
static void report_damage(cam_machine_t *m)
{
    const cam_status_t status = cam_machine_status(m);
    const bool is_idle = !cam_machine_is_pending(m, &status) &&
                         (status.state == cam_state_off || status.state == cam_state_fault);
    if (is_idle || cam_machine_post(m, &status, cam_request_table_fault) == cam_ok) {
        m->has_table = false;
    } // else a request is pending, and the next check round finds the damage again
}

/// Check whether state, sense of rotation and spindle speed allow a valid table.
static cam_err_t check_exchange(cam_machine_t *m, const cam_table_t *table)
{
    const cam_status_t status = cam_machine_status(m);
    if (cam_machine_is_pending(m, &status)) {
        return cam_err_busy;
    }
    if (status.state == cam_state_off) {
        return cam_ok;
    }
    if (status.state != cam_state_ready) {
        return cam_err_state;
    }
    // The angle counts in the table's sense of rotation, so the other sense needs new homing. The
    // spindle turns and changes to the table's speed at once.
    const bool is_same_sense = m->has_table && table->direction == m->table.direction;
    return is_same_sense ? cam_machine_judge(m, &m->params, table) : cam_err_table_sense;
}

cam_err_t cam_machine_check_table(cam_machine_t *m, const void *image, size_t size)
{
    cam_table_t table;
    const cam_err_t err = cam_table_check(image, size, &table);
    return err == cam_ok ? check_exchange(m, &table) : err;
}

cam_err_t cam_machine_select_table(cam_machine_t *m, const void *image, size_t size)
{
    cam_table_t table;
    cam_err_t err = cam_table_check(image, size, &table);
    if (err != cam_ok) {
        if (m->has_table && image == m->table.image) { // the table in use was overwritten
            report_damage(m);
        }
        return err;
    }
    err = check_exchange(m, &table);
    if (err == cam_ok) {
        err = cam_machine_hand_over(m, &m->params, &table, cam_pass_first(&m->params, &table));
    }
    if (err == cam_ok) {
        m->table = table;
        m->has_table = true;
        m->is_in_pass = false; // passes of the old table do not count
        m->n_checked = 0;
    }
    return err;
}

cam_err_t cam_machine_check_drives(const cam_params_t *params, const cam_status_t *status)
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
    if (hal_takes_force() && params->servo_crossover_hz == 0) {
        return cam_err_servo_none;
    }
    return cam_is_within(status->u_actual_nm, params->u_stroke_nm / 2) ? cam_ok : cam_err_u_place;
}

/// Check whether all passes are feasible.
static cam_err_t check_part(cam_machine_t *m)
{
    return m->has_table ? cam_machine_judge(m, &m->params, &m->table) : cam_err_no_table;
}

cam_err_t cam_machine_enable(cam_machine_t *m)
{
    const cam_status_t status = cam_machine_status(m);
    cam_err_t err = status.state == cam_state_off ? check_part(m) : cam_err_state;
    err = err == cam_ok ? cam_machine_check_drives(&m->params, &status) : err;
    err = err == cam_ok ? cam_machine_check_positions(m, &status) : err;
    err = err == cam_ok ? cam_machine_check_acknowledge(m, &status) : err;
    return err == cam_ok ? cam_machine_post(m, &status, cam_request_enable) : err;
}

cam_err_t cam_machine_disable(cam_machine_t *m)
{
    const cam_status_t status = cam_machine_status(m);
    if (status.state == cam_state_identifying) {
        return cam_machine_identify_stop(m, true);
    }
    const bool may_end = status.state == cam_state_homing || status.state == cam_state_ready ||
                         status.state == cam_state_manual;
    return may_end ? cam_machine_post(m, &status, cam_request_disable) : cam_err_state;
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

cam_err_t cam_machine_may_exchange(const cam_machine_t *m)
{
    const cam_status_t status = cam_machine_status(m);
    if (cam_machine_is_pending(m, &status) || status.config != m->generation || m->homes_again) {
        return cam_err_busy;
    }
    const bool is_idle = status.state == cam_state_off || status.state == cam_state_ready;
    return is_idle ? cam_ok : cam_err_state;
}

/// Detect the end of the pass and hand over the next one if the pass was completed. Retried while
/// the interrupt has not taken the last configuration.
static void end_pass(cam_machine_t *m, const cam_status_t *status)
{
    if (!m->is_in_pass || cam_machine_is_pending(m, status) ||
        cam_state_is_in_work(status->state)) {
        return;
    }
    const bool is_done = status->state == cam_state_ready && !m->is_cut_short;
    const uint32_t next = cam_pass_next(&m->params, &m->table, m->pass);
    const bool is_changed = is_done && m->has_table && next != m->pass;
    const bool is_last = m->params.pass > 0 || m->pass + 1u >= cam_pass_count(&m->table);
    m->is_in_pass = is_changed && cam_machine_hand_over(m, &m->params, &m->table, next) != cam_ok;
    m->n_parts += is_done && is_last && !m->is_in_pass ? 1u : 0u;
}

cam_err_t cam_machine_start(cam_machine_t *m)
{
    const cam_status_t status = cam_machine_status(m);
    end_pass(m, &status);
    if (status.state != cam_state_ready) {
        return cam_err_state;
    }
    cam_err_t err = check_part(m);
    err = err == cam_ok ? cam_machine_check_positions(m, &status) : err;
    // After a faster pass the spindle may still exceed the limit of this one.
    const bool is_too_fast = status.speed_q32 > cam_build_speed_q32(m->limit_mrpm, m->tick_hz);
    if (err == cam_ok && (m->is_in_pass || m->is_rate_due || is_too_fast)) {
        err = cam_err_busy;
    }
    err = err == cam_ok ? cam_machine_post(m, &status, cam_request_start) : err;
    if (err == cam_ok) {
        m->is_in_pass = true;
        m->is_cut_short = false;
        m->is_unsteady = false;
    }
    return err;
}

cam_err_t cam_machine_stop(cam_machine_t *m)
{
    const cam_status_t status = cam_machine_status(m);
    if (status.state == cam_state_identifying) {
        return cam_machine_identify_stop(m, false);
    }
    if (status.state == cam_state_manual) {
        return cam_machine_jog_stop(m);
    }
    const bool may_stop =
        cam_state_is_in_work(status.state) && status.state != cam_state_disengaging;
    const cam_err_t err = may_stop ? cam_machine_post(m, &status, cam_request_stop) : cam_err_state;
    // With a measured Z, stop is the regular end of a cut.
    const bool is_end = m->params.z_is_measured != 0 && status.state == cam_state_cutting;
    m->is_cut_short = m->is_cut_short || (err == cam_ok && !is_end);
    return err;
}

cam_err_t cam_machine_reset(cam_machine_t *m)
{
    const cam_status_t status = cam_machine_status(m);
    const bool may_reset = status.state == cam_state_fault && status.is_retracted;
    return may_reset ? cam_machine_post(m, &status, cam_request_reset) : cam_err_state;
}

/// Hold or resume the feed. cam_machine_poll() retries while the interrupt has not taken the last
/// configuration.
static void set_hold(cam_machine_t *m, bool is_held)
{
    m->is_held = is_held;
    m->is_rate_due = true;
    m->is_rate_due = cam_machine_hand_over(m, &m->params, &m->table, m->pass) != cam_ok;
}

cam_err_t cam_machine_hold(cam_machine_t *m)
{
    const cam_state_t state = cam_machine_status(m).state;
    if (m->params.z_is_measured != 0) {
        return cam_err_override_measured;
    }
    if (!m->has_table || !cam_state_is_in_work(state) || state == cam_state_disengaging) {
        return cam_err_state;
    }
    if (!m->is_held) {
        set_hold(m, true);
    }
    return cam_ok;
}

cam_err_t cam_machine_resume(cam_machine_t *m)
{
    if (!m->is_held) {
        return cam_err_state;
    }
    set_hold(m, false);
    return cam_ok;
}

cam_err_t cam_machine_set_parts(cam_machine_t *m, int32_t n)
{
    if (n < 0) {
        return cam_err_param_range;
    }
    m->n_parts = (uint32_t)n;
    return cam_ok;
}

/// Hand a hold over to the interrupt, and clear it after the cut.
static void poll_hold(cam_machine_t *m, const cam_status_t *status)
{
    const bool is_over =
        m->is_held && !cam_machine_is_pending(m, status) && !cam_state_is_in_work(status->state);
    if (is_over || (m->is_rate_due && m->has_table)) {
        set_hold(m, m->is_held && !is_over);
    }
}

/// End the approach, as by stop, when the spindle has not become steady for as long as homing waits
/// for it to turn.
static void poll_approach(cam_machine_t *m, const cam_status_t *status)
{
    const cam_steady_t *s = &status->steady;
    const cam_config_t *cfg = cam_machine_newest_config(m);
    if (s->n_agreeing == 0u && s->n_turns >= (uint32_t)least_turns &&
        s->waited_ticks > cfg->guard.homing_ticks && !cam_machine_is_pending(m, status)) {
        m->is_unsteady = cam_machine_stop(m) == cam_ok;
    }
}

/// Second half of cam_machine_home(): enable when the disable has taken effect. Another command or
/// a fault in between ends the attempt.
static void home_again(cam_machine_t *m)
{
    const cam_status_t status = cam_machine_status(m);
    if (!cam_machine_is_pending(m, &status)) {
        m->homes_again = status.state == cam_state_off && cam_machine_enable(m) == cam_err_busy;
    }
}

void cam_machine_poll(cam_machine_t *m)
{
    if (m->homes_again) {
        home_again(m);
    }
    cam_machine_scope_poll(m);
    cam_machine_identify_poll(m);
    cam_machine_jog_poll(m);
    const cam_status_t status = cam_machine_status(m);
    cam_machine_rights_poll(m, &status);
    end_pass(m, &status);
    poll_hold(m, &status);
    poll_approach(m, &status);
    cam_machine_ilc_poll(m, status.state, !status.is_u_at_rest);
    if (!m->has_table) {
        return;
    }
    const uint8_t *bytes = (const uint8_t *)m->table.image;
    if (m->n_checked == 0u) {
        m->n_checked = check_from;
        m->checked_crc = 0;
    }
    const uint32_t left = m->table.image_size - m->n_checked;
    const uint32_t n = left < check_bytes ? left : check_bytes;
    m->checked_crc = cam_crc32(m->checked_crc, bytes + m->n_checked, n);
    m->n_checked += n;
    if (m->n_checked == m->table.image_size) {
        m->n_checked = 0;
        if (m->checked_crc != m->table.crc32) {
            report_damage(m);
        }
    }
}
