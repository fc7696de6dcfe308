// SPDX-License-Identifier: Apache-2.0
#include "cam_remote_inner.h"
#include "cam_fix.h"     // cam_sat_i32
#include "cam_machine.h" // cam_machine_excite, cam_machine_jog, cam_machine_scope_start
#include "camturn.h"     // struct camturn_command_t
#include <stddef.h>      // NULL

// Parameters

/// @return the value in force, with a given error unless the parameter does not exist
static cam_outcome_t get(const cam_can_t *r, cam_param_id_t id, cam_err_t err)
{
    if (cam_param_info(id) == NULL) {
        return cam_outcome(cam_err_param_id);
    }
    return (cam_outcome_t){.err = err, .value = cam_param_get(&r->machine->params, id)};
}

static cam_outcome_t limit(cam_param_id_t id, bool is_lower)
{
    const cam_param_info_t *info = cam_param_info(id);
    if (info == NULL) {
        return cam_outcome(cam_err_param_id);
    }
    return (cam_outcome_t){.err = cam_ok, .value = is_lower ? info->min : info->max};
}

/// Add the range of a parameter if its value was refused for being out of it.
static cam_outcome_t with_range(cam_outcome_t outcome, cam_param_id_t id)
{
    if (outcome.err == cam_err_param_range || outcome.err == cam_err_hard_limit) {
        outcome.has_range = true;
        outcome.min = limit(id, true).value;
        outcome.max = limit(id, false).value;
    }
    return outcome;
}

/// Set a parameter; the answer gives the value in force.
static cam_outcome_t set(cam_can_t *r, cam_param_id_t id, int32_t value)
{
    return with_range(get(r, id, cam_machine_set_param(r->machine, id, value)), id);
}

static cam_outcome_t stage(cam_can_t *r, cam_param_id_t id, int32_t value)
{
    cam_outcome_t outcome = cam_outcome(cam_machine_stage(r->machine, id, value));
    if (outcome.err != cam_err_param_id && outcome.err != cam_err_params_begin) {
        outcome.value = cam_param_get(&r->machine->staged, id);
    }
    return with_range(outcome, id);
}

static cam_outcome_t with_version(const cam_can_t *r, cam_err_t err)
{
    return (cam_outcome_t){.err = err, .value = (int32_t)r->machine->version};
}

/// @return a field of the last refusal, saturated, with units as in cam_refusal_t
static cam_outcome_t get_refusal(const cam_refusal_t *last, uint32_t field)
{
    const int64_t values[cam_n_refusals] = {
        [cam_refusal_result] = (int64_t)last->err,
        [cam_refusal_needed] = last->needed,
        [cam_refusal_limit] = last->limit,
        [cam_refusal_highest_mrpm] = (int64_t)last->highest_mrpm,
        [cam_refusal_largest_feed_nm] = (int64_t)last->largest_feed_nm,
        [cam_refusal_pass] = (int64_t)last->pass,
        [cam_refusal_parameter] = (int64_t)last->param,
    };
    if (field >= (uint32_t)cam_n_refusals) {
        return cam_outcome(cam_err_param_id);
    }
    return (cam_outcome_t){.err = cam_ok, .value = cam_sat_i32(values[field])};
}

// Operation

/// Explain a refusal: without a table by the error of its check, of an infeasible speed by the
/// highest feasible one.
static cam_outcome_t explained(const cam_can_t *r, cam_err_t err)
{
    if (err == cam_err_no_table) {
        return cam_outcome(r->store.err);
    }
    const bool is_infeasible = err != cam_ok && err == cam_machine_feasibility(r->machine).err;
    return (cam_outcome_t){
        .err = err,
        .value = is_infeasible ? cam_sat_i32(cam_machine_highest_mrpm(r->machine)) : 0,
    };
}

static cam_outcome_t outcome_of(cam_verdict_t verdict)
{
    return (cam_outcome_t){.err = verdict.err, .value = verdict.value};
}

static cam_outcome_t place_of(const cam_can_t *r, hal_axis_t axis)
{
    if ((uint32_t)axis >= (uint32_t)hal_n_axes) {
        return cam_outcome(cam_err_hand_axis);
    }
    return (cam_outcome_t){.err = cam_ok, .value = cam_machine_position_nm(r->machine, axis)};
}

static cam_outcome_t with_parts(const cam_can_t *r, cam_err_t err)
{
    return (cam_outcome_t){.err = err, .value = cam_sat_i32((int64_t)r->machine->n_parts)};
}

// Tables, waves and recordings

cam_err_t cam_can_select(cam_can_t *r)
{
    const cam_err_t err = cam_table_store_select(&r->store);
    if (!cam_table_store_is_of_moment(err)) {
        cam_log_text_table(&r->lines, &r->store);
    }
    return err;
}

cam_outcome_t cam_can_received(const cam_can_t *r, cam_err_t err)
{
    const uint32_t n = r->is_wave ? r->machine->identify.received : r->store.received;
    return (cam_outcome_t){.err = err, .value = (int32_t)n};
}

/// Begin a download.
/// @param size  [bytes]
static cam_outcome_t begin_download(cam_can_t *r, uint32_t size, bool is_wave)
{
    r->is_wave = is_wave;
    r->download_session = r->machine->rights.session;
    return cam_can_received(r, is_wave ? cam_machine_wave_begin(r->machine, size)
                                       : cam_table_store_begin(&r->store, size));
}

/// @return a field of the recorder with the error of setting it, or else of reading it
static cam_outcome_t get_scope(const cam_can_t *r, uint32_t field, cam_err_t err)
{
    int32_t value = 0;
    const cam_err_t got = cam_machine_scope_get(r->machine, field, &value);
    return (cam_outcome_t){.err = err != cam_ok ? err : got, .value = value};
}

/// @return a learned value with the error of setting it, or else of reading it
static cam_outcome_t get_learned(const cam_can_t *r, uint32_t index, cam_err_t err)
{
    const cam_err_t got = index < cam_ilc_n_values ? cam_ok : cam_err_param_id;
    return (cam_outcome_t){.err = err != cam_ok ? err : got,
                           .value = cam_ilc_get(&r->machine->ilc, index)};
}

/// An FD piece is a multiple of this many words, at most that many times.
enum { fd_grain = 16, fd_most = 252 };

/// Begin sending a piece of the recording; unless it is refused, the answer follows it.
static cam_outcome_t read_scope(cam_can_t *r, const struct camturn_command_t *m, bool is_fd)
{
    const uint32_t most = (uint32_t)fd_most;
    const uint32_t grains = m->count < most ? m->count : most;
    const uint32_t n_words = is_fd ? grains * (uint32_t)fd_grain : m->count;
    r->reading.parameter = m->parameter;
    const cam_err_t err = cam_reading_begin(&r->reading, &r->machine->scope, m->offset, n_words,
                                            is_fd, cam_status_tick(r->machine->core));
    return (cam_outcome_t){.err = err, .is_deferred = err == cam_ok};
}

// Rights

static cam_outcome_t take_session(cam_can_t *r, const struct camturn_command_t *m)
{
    const uint32_t tick = cam_status_tick(r->machine->core);
    const cam_err_t err =
        cam_rights_take(&r->machine->rights, m->sender, m->is_take_over != 0u, tick);
    const int32_t session = err == cam_ok ? (int32_t)r->machine->rights.session : 0;
    return (cam_outcome_t){.err = err, .value = session};
}

// The commands

/// Right that a command requires.
typedef enum {
    right_command,  ///< the current session; an unknown command, too
    right_none,     ///< reading, and stop
    right_unlocked, ///< the current session in the unlocked level
} right_t;

// clang-format off
/// The outcome of a command that cannot fail.
#define DONE(call) ((call), cam_outcome(cam_ok))

/// X(name, right, outcome): every command, the right that it requires, and the expression that
/// executes it and gives its outcome. The machine checks the state, for callers other than this one, too.
#define COMMANDS(X) \
    X(ENABLE,            command,  explained(r, cam_machine_enable(machine))) \
    X(HOME,              command,  explained(r, cam_machine_home(machine))) \
    X(DISABLE,           command,  cam_outcome(cam_machine_disable(machine))) \
    X(START,             command,  explained(r, cam_machine_start(machine))) \
    X(STOP,              none,     cam_outcome(cam_machine_stop(machine))) \
    X(RESET,             command,  cam_outcome(cam_machine_reset(machine))) \
    X(HOLD,              command,  cam_outcome(cam_machine_hold(machine))) \
    X(RESUME,            command,  cam_outcome(cam_machine_resume(machine))) \
    X(SET_PARAMETER,     command,  set(r, id, m->value)) \
    X(GET_PARAMETER,     none,     get(r, id, cam_ok)) \
    X(GET_MINIMUM,       none,     limit(id, true)) \
    X(GET_MAXIMUM,       none,     limit(id, false)) \
    X(GET_REFUSAL,       none,     get_refusal(&machine->refusal, m->parameter)) \
    X(BEGIN_PARAMETERS,  command,  (cam_machine_stage_begin(machine), with_version(r, cam_ok))) \
    X(STAGE_PARAMETER,   command,  stage(r, id, m->value)) \
    X(COMMIT_PARAMETERS, command,  with_version(r, cam_machine_stage_commit(machine))) \
    X(SAVE_PARAMETERS,   command,  with_version(r, cam_machine_save_params(machine))) \
    X(RESTORE_DEFAULTS,  command,  with_version(r, cam_machine_restore_defaults(machine))) \
    X(REVERT_PARAMETERS, command,  with_version(r, cam_machine_revert_params(machine))) \
    X(SET_PARTS,         command,  with_parts(r, cam_machine_set_parts(machine, m->parts))) \
    X(GET_PARTS,         none,     with_parts(r, cam_ok)) \
    /* Downloads */ \
    X(SELECT_TABLE,      unlocked, cam_outcome(cam_can_select(r))) \
    X(BEGIN_DOWNLOAD,    unlocked, begin_download(r, m->size, false)) \
    X(END_DOWNLOAD,      unlocked, cam_can_received(r, cam_table_store_end(&r->store, m->crc))) \
    X(BEGIN_WAVE,        command,  begin_download(r, m->size, true)) \
    X(END_WAVE,          command,  cam_can_received(r, cam_machine_wave_end(machine, m->crc))) \
    /* Axes by hand */ \
    X(MANUAL,            command,  cam_outcome(cam_machine_manual(machine))) \
    X(JOG,               command,  outcome_of(cam_machine_jog(machine, axis, m->jog_speed))) \
    X(STEP,              command,  outcome_of(cam_machine_step(machine, axis, m->step))) \
    X(HOME_AXIS,         command,  cam_outcome(cam_machine_home_axis(machine, axis))) \
    X(ZERO_X,            command,  outcome_of(cam_machine_zero(machine, hal_axis_x, m->diameter))) \
    X(ZERO_Z,            command,  outcome_of(cam_machine_zero(machine, hal_axis_z, m->height))) \
    X(GET_PLACE,         none,     place_of(r, axis)) \
    /* Recorder, excitation and learning */ \
    X(SET_SCOPE,         command,  get_scope(r, m->parameter, \
                                             cam_machine_scope_set(machine, m->parameter, m->value))) \
    X(GET_SCOPE,         none,     get_scope(r, m->parameter, cam_ok)) \
    X(START_SCOPE,       command,  cam_outcome(cam_machine_scope_start(machine))) \
    X(STOP_SCOPE,        command,  DONE(cam_machine_scope_stop(machine))) \
    X(RELEASE_SCOPE,     command,  cam_outcome(cam_machine_release(machine))) \
    X(READ_SCOPE,        none,     read_scope(r, m, false)) \
    X(READ_SCOPE_FD,     none,     read_scope(r, m, true)) \
    X(EXCITE,            command,  outcome_of(cam_machine_excite(machine, m->periods, m->fade))) \
    X(KEEP_ALIVE,        command,  DONE(cam_machine_keep_alive(machine))) \
    X(GET_LEARNED,       none,     get_learned(r, m->parameter, cam_ok)) \
    X(SET_LEARNED,       unlocked, get_learned(r, m->parameter, \
                                               cam_machine_set_learned(machine, m->parameter, m->value))) \
    /* Rights; the commander has been heard already */ \
    X(TAKE_COMMAND,      none,     take_session(r, m)) \
    X(RELEASE_COMMAND,   command,  DONE(cam_machine_release_command(machine))) \
    X(HEARTBEAT,         command,  cam_outcome(cam_ok)) \
    X(LOCK,              command,  DONE(cam_rights_lock(rights)))
// clang-format on

#define RIGHT(name, right, outcome) [CAMTURN_COMMAND_COMMAND_##name##_CHOICE] = right_##right,

cam_err_t cam_can_admit(const cam_rights_t *rights, const struct camturn_command_t *m)
{
    static const uint8_t required[UINT8_MAX + 1] = {COMMANDS(RIGHT)};
    const right_t right = (right_t)required[m->command];
    if (right == right_none) {
        return cam_ok;
    }
    if (!cam_rights_is_commander(rights, m->sender, m->session)) {
        return cam_err_not_commander;
    }
    return right == right_unlocked ? cam_rights_check_level(rights) : cam_ok;
}

#define EXECUTE(name, right, outcome)                                                              \
    case CAMTURN_COMMAND_COMMAND_##name##_CHOICE:                                                  \
        return (outcome);

cam_outcome_t cam_can_carry_out(cam_can_t *r, const struct camturn_command_t *m)
{
    cam_machine_t *machine = r->machine;
    cam_rights_t *rights = &machine->rights;
    const cam_param_id_t id = (cam_param_id_t)m->parameter;
    const hal_axis_t axis = (hal_axis_t)m->parameter;
    switch (m->command) {
        COMMANDS(EXECUTE)
    default:
        return cam_outcome(cam_err_command);
    }
}
