// SPDX-License-Identifier: Apache-2.0
#include "lcn_slow.h"
#include "cam_feasible.h" // cam_derived_limits_most
#include "cam_fix.h"      // cam_clamp_i32
#include "cam_machine.h"  // cam_machine_t, cam_machine_home_axis
#include "cam_state.h"    // cam_state_name
#include "lcn_port.h"     // lcn_port_print
#include "lcn_record.h"   // lcn_record_poll
#include "lcn_reload.h"   // lcn_reload_ask, lcn_table_read
#include <stddef.h>       // NULL
#include <stdio.h>        // snprintf

enum { line_bytes = 256, updates_per_turn = 100 };

typedef enum { home_none, home_due, home_ordered } home_phase_t;

static struct {
    cam_machine_t machine;
    lcn_commands_t last; ///< commands of the last round
    bool wants_enable;   ///< enable is requested and not yet done
    bool wants_start;    ///< likewise
    bool wants_table;    ///< likewise
    home_phase_t home;   ///< of U, before an enable
    bool is_recording;   ///< a recording is not yet finished
    bool was_on_rate;
    cam_err_t err;
    cam_state_t state; ///< of the last round
} slow;

static void report_refusal(const char *what, cam_err_t err)
{
    char line[line_bytes];
    (void)snprintf(line, sizeof line, "%s: refused: %s (error %d)", what, cam_err_text(err),
                   (int)err);
    lcn_port_print(line);
}

/// @return whether the request is finished: done, or refused with a message; false while busy
static bool settle(const char *what, cam_err_t err)
{
    if (err == cam_err_busy) {
        return false;
    }
    slow.err = err;
    if (err != cam_ok) {
        report_refusal(what, err);
    }
    return true;
}

void lcn_slow_init(uint32_t tick_hz, const char *recordings)
{
    slow.last = (lcn_commands_t){0};
    slow.wants_enable = false;
    slow.wants_start = false;
    slow.wants_table = false;
    slow.home = home_none;
    slow.is_recording = false;
    slow.was_on_rate = true;
    slow.err = cam_ok;
    slow.state = cam_state_off;
    cam_machine_init(&slow.machine, &g_cam, tick_hz, hal_clock_hz());
    lcn_record_begin(&slow.machine, recordings);
}

bool lcn_slow_load(const char *path)
{
    lcn_table_t table;
    if (!lcn_table_read(path, &table)) {
        lcn_port_print(table.error);
        return false;
    }
    const cam_err_t err = cam_machine_select_table(&slow.machine, table.bytes, table.size);
    if (err != cam_ok) {
        report_refusal(path, err);
    }
    (void)cam_config_take_isr(&g_cam.config); // in place of the tick, which does not run yet
    return err == cam_ok;
}

/// Replace the table by the present content of its file (lcn_reload.h), in the states off and
/// ready.
/// @return whether that is finished: done, or refused with a message
static bool reload(void)
{
    const lcn_table_t *table = lcn_reload_table();
    switch (lcn_reload_phase()) {
    case lcn_reload_idle:
        lcn_reload_ask();
        return false;
    case lcn_reload_asked:
        return false;
    case lcn_reload_failed:
        lcn_port_print(table->error);
        lcn_reload_settle(false);
        return true;
    case lcn_reload_read:
        break;
    }
    const cam_err_t err = cam_machine_select_table(&slow.machine, table->bytes, table->size);
    const bool is_settled = settle("table", err);
    if (is_settled) {
        lcn_reload_settle(err == cam_ok);
    }
    return is_settled;
}

static void refuse_param(const cam_param_info_t *info, int32_t value, cam_err_t err)
{
    char line[line_bytes];
    (void)snprintf(line, sizeof line, "%s = %d: refused: %s (error %d); give %d .. %d", info->name,
                   (int)value, cam_err_text(err), (int)err, (int)info->min, (int)info->max);
    lcn_port_print(line);
}

/// Report why parameters were refused, with the name of the responsible one if known.
static void refuse_params(cam_err_t err)
{
    const cam_param_info_t *info = cam_param_info(cam_machine_refusal(&slow.machine, err).param);
    char line[line_bytes];
    (void)snprintf(line, sizeof line, "parameters: refused in state %s: %s%s%s (error %d)",
                   cam_state_name(cam_machine_status(&slow.machine).state),
                   info != NULL ? info->name : "", info != NULL ? ": " : "", cam_err_text(err),
                   (int)err);
    lcn_port_print(line);
}

/// @return [mHz] observer bandwidth for the commanded speed, MATHS.md (188), limited by the tick
/// rate
static int32_t derived_observer_mHz(void)
{
    const cam_params_t *p = &slow.machine.params;
    const int64_t mrpm =
        p->spindle_mrpm > 0 ? p->spindle_mrpm : (int64_t)slow.machine.table.spindle_mrpm;
    const cam_param_id_t id = cam_param_observer_bandwidth_mHz;
    return cam_clamp_i32(cam_sat_i32(mrpm * (480000 + mrpm) / 3600000), cam_param_info(id)->min,
                         cam_derived_limits_most(id, slow.machine.tick_hz));
}

/// @return what a pin adds to a parameter
static int32_t added(cam_param_id_t id, const lcn_commands_t *commands)
{
    return id == cam_param_x_trim_nm    ? commands->x_trim_nm
           : id == cam_param_phase_udeg ? commands->phase_udeg
                                        : 0;
}

/// @return the parameter for a HAL value; 0 of the observer bandwidth means derived
static int32_t wanted(cam_param_id_t id, int32_t value, const lcn_commands_t *commands)
{
    if (id != cam_param_observer_bandwidth_mHz || value != 0) {
        return cam_sat_i32((int64_t)value + added(id, commands));
    }
    const bool is_off = cam_machine_status(&slow.machine).state == cam_state_off;
    return is_off ? derived_observer_mHz() : slow.machine.params.observer_bandwidth_mHz;
}

/// Stage the HAL values; a value out of range is reset. @return whether anything changed
static bool stage(volatile int32_t *values, const lcn_commands_t *commands)
{
    bool is_changed = false;
    cam_machine_stage_begin(&slow.machine);
    for (int32_t i = 0; i < (int32_t)cam_n_params; i++) {
        const cam_param_id_t id = (cam_param_id_t)i;
        const int32_t value = wanted(id, values[i], commands);
        const cam_err_t err = cam_machine_stage(&slow.machine, id, value);
        if (err != cam_ok) {
            slow.err = err;
            refuse_param(cam_param_info(id), value, err);
            values[i] = lcn_slow_param(i) - added(id, commands);
        }
        is_changed = is_changed || (err == cam_ok && value != lcn_slow_param(i));
    }
    return is_changed;
}

/// Apply all changed parameters in one tick. Refused ones are reset in HAL.
static void take_params(volatile int32_t *values, const lcn_commands_t *commands)
{
    const cam_err_t err =
        stage(values, commands) ? cam_machine_stage_commit(&slow.machine) : cam_ok;
    if (err != cam_ok && err != cam_err_busy) {
        slow.err = err;
        refuse_params(err);
        for (int32_t i = 0; i < (int32_t)cam_n_params; i++) {
            if (values[i] != 0 || lcn_slow_default(i) != 0) {
                values[i] = lcn_slow_param(i) - added((cam_param_id_t)i, commands);
            }
        }
    }
}

/// Discard the result of a command that is repeated every round until the state changes.
static void discard(cam_err_t err)
{
    (void)err;
}

/// Home U: off -> manual. The enable waits.
static void go_home(void)
{
    const cam_err_t err = cam_machine_manual(&slow.machine);
    slow.wants_enable = !settle("home U", err) || err == cam_ok;
    slow.home = err == cam_ok ? home_due : slow.home;
}

/// In manual: order the homing, then -> off. If it fails, the enable is given up.
static void home(const cam_status_t *status)
{
    const bool rests =
        status->jog.phase == cam_jog_rest && status->jog.serial == slow.machine.offsets.serial;
    if (!rests) {
        cam_machine_keep_alive(&slow.machine);
    } else if (cam_offsets_is_known(&slow.machine.params, status, hal_axis_u)) {
        discard(cam_machine_disable(&slow.machine)); // then, in off, enable
    } else if (slow.home == home_ordered) {
        lcn_port_print("home U: no home within the stroke: check u-home-switch, u-index, "
                       "u-home-sense");
        slow.wants_enable = false;
    } else {
        const cam_err_t err = cam_machine_home_axis(&slow.machine, hal_axis_u);
        slow.wants_enable = !settle("home U", err) || err == cam_ok;
        slow.home = err == cam_ok ? home_ordered : slow.home;
    }
}

/// Enable; in a fault, reset it first. Home U if its position is not known.
static void enable(const cam_status_t *status)
{
    if (status->state == cam_state_fault) {
        discard(cam_machine_reset(&slow.machine)); // refused until the retract has ended
        return;
    }
    if (status->state == cam_state_manual) {
        home(status);
        return;
    }
    const bool is_off = status->state == cam_state_off;
    if (is_off && !cam_offsets_is_known(&slow.machine.params, status, hal_axis_u)) {
        go_home();
    } else {
        slow.home = home_none;
        slow.wants_enable = is_off && !settle("enable", cam_machine_enable(&slow.machine));
    }
}

static void disable(const cam_status_t *status)
{
    if (cam_state_is_in_work(status->state)) {
        discard(cam_machine_stop(&slow.machine)); // then, in ready, disable
    } else if (status->state == cam_state_ready || status->state == cam_state_homing ||
               status->state == cam_state_manual) {
        discard(cam_machine_disable(&slow.machine));
    } else {
        // already disabled, or on the way
    }
}

/// A start before the machine is ready is refused, not stored: the cut could otherwise begin after
/// the G-code program has stopped waiting for "in cut".
static void start_or_stop(const cam_status_t *status, const lcn_commands_t *commands)
{
    if (slow.wants_start) {
        slow.wants_start = !settle("start", cam_machine_start(&slow.machine));
    } else if (!commands->starts && cam_state_is_in_work(status->state) &&
               status->state != cam_state_disengaging) {
        discard(cam_machine_stop(&slow.machine));
    } else {
        // the pass continues
    }
}

static void execute(const lcn_commands_t *commands)
{
    const cam_status_t status = cam_machine_status(&slow.machine);
    if (status.config == 0u) {
        return; // no tick has run yet
    }
    slow.wants_enable =
        commands->enables && (slow.wants_enable || (!slow.last.enables && commands->enables));
    slow.wants_start = commands->starts && (slow.wants_start || !slow.last.starts);
    slow.last = *commands;
    if (status.state == cam_state_fault && slow.home != home_none) { // do not try again and again
        slow.home = home_none;
        slow.wants_enable = false;
    }
    if (slow.wants_enable) {
        enable(&status);
    } else if (!commands->enables || status.state == cam_state_manual) {
        disable(&status);
    } else {
        start_or_stop(&status, commands);
    }
}

/// Report a new fault, and a thread at the wrong rate.
static void report(void)
{
    char line[line_bytes];
    const cam_status_t status = cam_machine_status(&slow.machine);
    if (status.state == cam_state_fault && slow.state != cam_state_fault) {
        for (uint32_t i = 0; i < cam_n_faults; i++) {
            if ((status.first_fault >> i & 1u) != 0u) {
                (void)snprintf(line, sizeof line, "fault %s: %s", cam_fault_name((cam_fault_t)i),
                               cam_fault_text((cam_fault_t)i));
                lcn_port_print(line);
            }
        }
    }
    slow.state = status.state;
    const bool is_on_rate = lcn_port_is_on_rate();
    if (!is_on_rate && slow.was_on_rate) {
        const int period_ns = (int)lcn_port_period_ns();
        (void)snprintf(line, sizeof line,
                       "the thread of camturn.update has a period of %d ns, but tick_hz = %u was "
                       "given: load camturn with tick_hz=%d",
                       period_ns, (unsigned)slow.machine.tick_hz,
                       (1000000000 + period_ns / 2) / period_ns);
        lcn_port_print(line);
    }
    slow.was_on_rate = is_on_rate;
}

/// Learning needs a hundred updates per turn; a slow thread does several in one round.
static void learn(int32_t period_ns)
{
    const int64_t turns_per_s = slow.machine.params.spindle_limit_mrpm / 60000 + 1;
    const int64_t n = turns_per_s * updates_per_turn * period_ns / 1000000000;
    for (int64_t i = 0; i < n; i++) {
        const cam_status_t status = cam_machine_status(&slow.machine);
        cam_machine_ilc_poll(&slow.machine, status.state, !status.is_u_at_rest);
    }
}

void lcn_slow_poll(volatile int32_t *values, const lcn_commands_t *commands, int32_t period_ns)
{
    take_params(values, commands);
    lcn_port_run(); // effective in the first round
    slow.wants_table = slow.wants_table || (commands->reloads && !slow.last.reloads);
    slow.wants_table = slow.wants_table && !reload();
    execute(commands);
    cam_machine_poll(&slow.machine);
    slow.is_recording = lcn_record_poll(&slow.machine, commands->records);
    learn(period_ns);
    report();
}

int32_t lcn_slow_n_params(void)
{
    return (int32_t)cam_n_params;
}

const char *lcn_slow_param_name(int32_t index)
{
    return cam_param_info((cam_param_id_t)index)->name;
}

int32_t lcn_slow_default(int32_t index)
{
    return index == (int32_t)cam_param_observer_bandwidth_mHz ? 0 : lcn_slow_param(index);
}

int32_t lcn_slow_param(int32_t index)
{
    return cam_param_get(&slow.machine.params, (cam_param_id_t)index);
}

int32_t lcn_slow_turn_counts(void)
{
    return slow.machine.params.counts_per_turn;
}

lcn_status_t lcn_slow_status(void)
{
    const double turn = 4294967296.0;
    const cam_status_t status = cam_machine_status(&slow.machine);
    return (lcn_status_t){
        .error = slow.err,
        .state = status.state,
        .is_ready = status.state == cam_state_ready,
        .is_homed = cam_offsets_is_known(&slow.machine.params, &status, hal_axis_u),
        .is_reloading = slow.wants_table,
        .is_recording = slow.is_recording,
        .faults = status.faults,
        .n_late = status.n_late,
        .turns = (double)status.pos_q32 / turn,
        .rpm = status.speed_q32 / turn * slow.machine.tick_hz * 60.0,
        .u_nm = status.u_actual_nm,
        .following_nm = status.following_nm,
        .learned_nm = cam_machine_learning(&slow.machine).error_nm,
    };
}
