// SPDX-License-Identifier: Apache-2.0
#include "cam_can_inner.h"
#include "cam_fix.h"              // cam_sat_i32
#include "cam_machine_identify.h" // cam_machine_excite
#include "cam_machine_jog.h"      // cam_machine_jog
#include "cam_machine_scope.h"    // cam_machine_scope_start
#include <stddef.h>               // NULL

// Parameters

/// @return the value in force, with a given error unless the parameter does not exist
static cam_outcome_t get(const cam_can_t *r, cam_param_id_t id, cam_err_t err)
{
    if (cam_param_info(id) == NULL) {
        return cam_outcome(cam_err_param_id);
    }
    return (cam_outcome_t){.err = err, .value = cam_param_get(&r->machine->params, id)};
}

/// @return the smallest or the largest value that a parameter can take
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

/// Set a parameter; the answer echoes its id and gives the value in force.
static cam_outcome_t set(cam_can_t *r, struct camturn_command_t *m, cam_param_id_t id,
                         int32_t value)
{
    m->parameter = (uint8_t)id;
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

/// @return a result with the version of the parameters in force
static cam_outcome_t with_version(const cam_can_t *r, cam_err_t err)
{
    return (cam_outcome_t){.err = err, .value = (int32_t)r->machine->version};
}

/// @return a field of the last refusal, saturated, with units as in cam_feasibility_t
static cam_outcome_t get_refusal(const cam_refusal_t *last, uint32_t field)
{
    const int64_t values[cam_n_refusals] = {
        [cam_refusal_result] = (int64_t)last->why.err,
        [cam_refusal_needed] = last->why.needed,
        [cam_refusal_limit] = last->why.limit,
        [cam_refusal_highest_mrpm] = (int64_t)last->why.highest_mrpm,
        [cam_refusal_largest_feed_nm] = (int64_t)last->why.largest_feed_nm,
        [cam_refusal_pass] = (int64_t)last->why.pass,
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
    const bool is_infeasible = err != cam_ok && err == cam_machine_check_speed(r->machine, 0);
    return (cam_outcome_t){
        .err = err,
        .value = is_infeasible ? cam_sat_i32(cam_machine_highest_mrpm(r->machine)) : 0,
    };
}

static cam_outcome_t outcome_of(cam_verdict_t verdict)
{
    return (cam_outcome_t){.err = verdict.err, .value = verdict.value};
}

/// @return position of an axis in machine coordinates
static cam_outcome_t place_of(const cam_can_t *r, hal_axis_t axis)
{
    if ((uint32_t)axis >= (uint32_t)hal_n_axes) {
        return cam_outcome(cam_err_hand_axis);
    }
    return (cam_outcome_t){.err = cam_ok, .value = cam_machine_position_nm(r->machine, axis)};
}

/// @return an error with the number of parts
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
    int32_t value = 0;
    const cam_err_t got = cam_machine_get_learned(r->machine, index, &value);
    return (cam_outcome_t){.err = err != cam_ok ? err : got, .value = value};
}

/// Begin sending a piece of the recording; unless it is refused, the answer follows it.
static cam_outcome_t read_scope(cam_can_t *r, const struct camturn_command_t *m, bool is_fd)
{
    const uint32_t most = (uint32_t)cam_reading_fd_most;
    const uint32_t grains = m->count < most ? m->count : most;
    const uint32_t n_words = is_fd ? grains * (uint32_t)cam_reading_fd_grain : m->count;
    r->reading.parameter = m->parameter;
    const cam_err_t err = cam_reading_begin(&r->reading, &r->machine->scope, m->offset, n_words,
                                            is_fd, cam_machine_status(r->machine).tick);
    return (cam_outcome_t){.err = err, .is_deferred = err == cam_ok};
}

static cam_outcome_t strobe(cam_can_t *r, uint32_t every)
{
    cam_machine_t *machine = r->machine;
    const cam_err_t err = cam_machine_strobe(machine, every);
    return (cam_outcome_t){.err = err,
                           .value = (int32_t)machine->strobe.every,
                           .has_range = err == cam_err_param_range,
                           .min = (int32_t)cam_strobe_least(machine->tick_hz),
                           .max = (int32_t)machine->tick_hz};
}

// Rights

static cam_outcome_t take_session(cam_can_t *r, const struct camturn_command_t *m)
{
    const uint32_t tick = cam_machine_status(r->machine).tick;
    const cam_err_t err =
        cam_rights_take(&r->machine->rights, m->sender, m->is_take_over != 0u, tick);
    const int32_t session = err == cam_ok ? (int32_t)r->machine->rights.session : 0;
    return (cam_outcome_t){.err = err, .value = session};
}

static cam_outcome_t challenge(cam_can_t *r, uint32_t tick)
{
    uint32_t number = 0;
    const cam_err_t err = cam_rights_challenge(&r->machine->rights, tick, &number);
    return (cam_outcome_t){.err = err, .value = (int32_t)number};
}

// The commands, in groups: each group offers a command that is not its own to the next one.

static cam_outcome_t carry_out_rights(cam_can_t *r, const struct camturn_command_t *m)
{
    cam_rights_t *rights = &r->machine->rights;
    const uint32_t tick = cam_machine_status(r->machine).tick;
    switch (m->command) {
    case CAMTURN_COMMAND_COMMAND_TAKE_COMMAND_CHOICE:
        return take_session(r, m);
    case CAMTURN_COMMAND_COMMAND_RELEASE_COMMAND_CHOICE:
        cam_machine_release_command(r->machine);
        return cam_outcome(cam_ok);
    case CAMTURN_COMMAND_COMMAND_HEARTBEAT_CHOICE: // the commander has been heard already
        return cam_outcome(cam_ok);
    case CAMTURN_COMMAND_COMMAND_GET_CHALLENGE_CHOICE:
        return challenge(r, tick);
    case CAMTURN_COMMAND_COMMAND_UNLOCK_CHOICE:
        return cam_outcome(cam_rights_unlock(rights, m->unlock_answer, tick));
    case CAMTURN_COMMAND_COMMAND_LOCK_CHOICE:
        cam_rights_lock(rights);
        return cam_outcome(cam_ok);
    default:
        return cam_outcome(cam_err_command);
    }
}

/// Recorder, excitation and learning.
static cam_outcome_t carry_out_scope(cam_can_t *r, const struct camturn_command_t *m)
{
    cam_machine_t *machine = r->machine;
    switch (m->command) {
    case CAMTURN_COMMAND_COMMAND_SET_SCOPE_CHOICE:
        return get_scope(r, m->parameter, cam_machine_scope_set(machine, m->parameter, m->value));
    case CAMTURN_COMMAND_COMMAND_GET_SCOPE_CHOICE:
        return get_scope(r, m->parameter, cam_ok);
    case CAMTURN_COMMAND_COMMAND_START_SCOPE_CHOICE:
        return cam_outcome(cam_machine_scope_start(machine));
    case CAMTURN_COMMAND_COMMAND_STOP_SCOPE_CHOICE:
        cam_machine_scope_stop(machine);
        return cam_outcome(cam_ok);
    case CAMTURN_COMMAND_COMMAND_RELEASE_SCOPE_CHOICE:
        return cam_outcome(cam_machine_release(machine));
    case CAMTURN_COMMAND_COMMAND_READ_SCOPE_CHOICE:
        return read_scope(r, m, false);
    case CAMTURN_COMMAND_COMMAND_READ_SCOPE_FD_CHOICE:
        return read_scope(r, m, true);
    case CAMTURN_COMMAND_COMMAND_STROBE_CHOICE:
        return strobe(r, m->every);
    case CAMTURN_COMMAND_COMMAND_EXCITE_CHOICE:
        return outcome_of(cam_machine_excite(machine, m->periods, m->fade));
    case CAMTURN_COMMAND_COMMAND_KEEP_ALIVE_CHOICE:
        cam_machine_keep_alive(machine);
        return cam_outcome(cam_ok);
    case CAMTURN_COMMAND_COMMAND_GET_LEARNED_CHOICE:
        return get_learned(r, m->parameter, cam_ok);
    case CAMTURN_COMMAND_COMMAND_SET_LEARNED_CHOICE:
        return get_learned(r, m->parameter,
                           cam_machine_set_learned(machine, m->parameter, m->value));
    default:
        return carry_out_rights(r, m);
    }
}

/// Downloads, jogging and the number of parts.
static cam_outcome_t carry_out_jog(cam_can_t *r, const struct camturn_command_t *m)
{
    cam_machine_t *machine = r->machine;
    const hal_axis_t axis = (hal_axis_t)m->parameter;
    switch (m->command) {
    case CAMTURN_COMMAND_COMMAND_SELECT_TABLE_CHOICE:
        return cam_outcome(cam_can_select(r));
    case CAMTURN_COMMAND_COMMAND_BEGIN_DOWNLOAD_CHOICE:
        return begin_download(r, m->size, false);
    case CAMTURN_COMMAND_COMMAND_END_DOWNLOAD_CHOICE:
        return cam_can_received(r, cam_table_store_end(&r->store, m->crc));
    case CAMTURN_COMMAND_COMMAND_BEGIN_WAVE_CHOICE:
        return begin_download(r, m->size, true);
    case CAMTURN_COMMAND_COMMAND_END_WAVE_CHOICE:
        return cam_can_received(r, cam_machine_wave_end(machine, m->crc));
    case CAMTURN_COMMAND_COMMAND_JOG_CHOICE:
        return outcome_of(cam_machine_jog(machine, axis, m->jog_speed));
    case CAMTURN_COMMAND_COMMAND_STEP_CHOICE:
        return outcome_of(cam_machine_step(machine, axis, m->step));
    case CAMTURN_COMMAND_COMMAND_HOME_AXIS_CHOICE:
        return cam_outcome(cam_machine_home_axis(machine, axis));
    case CAMTURN_COMMAND_COMMAND_ZERO_X_CHOICE:
        return outcome_of(cam_machine_zero(machine, hal_axis_x, m->diameter));
    case CAMTURN_COMMAND_COMMAND_ZERO_Z_CHOICE:
        return outcome_of(cam_machine_zero(machine, hal_axis_z, m->height));
    case CAMTURN_COMMAND_COMMAND_GET_PLACE_CHOICE:
        return place_of(r, axis);
    case CAMTURN_COMMAND_COMMAND_SET_PARTS_CHOICE:
        return with_parts(r, cam_machine_set_parts(machine, m->parts));
    case CAMTURN_COMMAND_COMMAND_GET_PARTS_CHOICE:
        return with_parts(r, cam_ok);
    default:
        return carry_out_scope(r, m);
    }
}

/// States of the machine, and parameters other than by setting one.
static cam_outcome_t carry_out_state(cam_can_t *r, const struct camturn_command_t *m)
{
    cam_machine_t *machine = r->machine;
    switch (m->command) {
    case CAMTURN_COMMAND_COMMAND_ENABLE_CHOICE:
        return explained(r, cam_machine_enable(machine));
    case CAMTURN_COMMAND_COMMAND_HOME_CHOICE:
        return explained(r, cam_machine_home(machine));
    case CAMTURN_COMMAND_COMMAND_DISABLE_CHOICE:
        return cam_outcome(cam_machine_disable(machine));
    case CAMTURN_COMMAND_COMMAND_START_CHOICE:
        return explained(r, cam_machine_start(machine));
    case CAMTURN_COMMAND_COMMAND_STOP_CHOICE:
        return cam_outcome(cam_machine_stop(machine));
    case CAMTURN_COMMAND_COMMAND_RESET_CHOICE:
        return cam_outcome(cam_machine_reset(machine));
    case CAMTURN_COMMAND_COMMAND_HOLD_CHOICE:
        return cam_outcome(cam_machine_hold(machine));
    case CAMTURN_COMMAND_COMMAND_RESUME_CHOICE:
        return cam_outcome(cam_machine_resume(machine));
    case CAMTURN_COMMAND_COMMAND_MANUAL_CHOICE:
        return cam_outcome(cam_machine_manual(machine));
    case CAMTURN_COMMAND_COMMAND_BEGIN_PARAMETERS_CHOICE:
        cam_machine_stage_begin(machine);
        return with_version(r, cam_ok);
    case CAMTURN_COMMAND_COMMAND_COMMIT_PARAMETERS_CHOICE:
        return with_version(r, cam_machine_stage_commit(machine));
    case CAMTURN_COMMAND_COMMAND_SAVE_PARAMETERS_CHOICE:
        return with_version(r, cam_machine_save_params(machine));
    case CAMTURN_COMMAND_COMMAND_RESTORE_DEFAULTS_CHOICE:
        return with_version(r, cam_machine_restore_defaults(machine));
    case CAMTURN_COMMAND_COMMAND_REVERT_PARAMETERS_CHOICE:
        return with_version(r, cam_machine_revert_params(machine));
    default:
        return carry_out_jog(r, m);
    }
}

cam_outcome_t cam_can_carry_out(cam_can_t *r, struct camturn_command_t *m)
{
    const cam_param_id_t id = (cam_param_id_t)m->parameter;
    switch (m->command) {
    case CAMTURN_COMMAND_COMMAND_SET_PARAMETER_CHOICE:
        return set(r, m, id, m->value);
    case CAMTURN_COMMAND_COMMAND_SET_SPEED_CHOICE:
        return set(r, m, cam_param_spindle_mrpm, m->speed);
    case CAMTURN_COMMAND_COMMAND_SET_FEED_CHOICE:
        return set(r, m, cam_param_feed_nm, m->feed);
    case CAMTURN_COMMAND_COMMAND_SET_AMPLITUDE_CHOICE:
        return set(r, m, cam_param_amplitude_ppm, m->amplitude);
    case CAMTURN_COMMAND_COMMAND_SET_PHASE_CHOICE:
        return set(r, m, cam_param_phase_udeg, m->phase);
    case CAMTURN_COMMAND_COMMAND_SET_FEED_OVERRIDE_CHOICE:
        return set(r, m, cam_param_feed_override_ppm, m->feed_override);
    case CAMTURN_COMMAND_COMMAND_SET_SPINDLE_OVERRIDE_CHOICE:
        return set(r, m, cam_param_spindle_override_ppm, m->spindle_override);
    case CAMTURN_COMMAND_COMMAND_SET_TRIM_CHOICE:
        return set(r, m, cam_param_x_trim_nm, m->trim);
    case CAMTURN_COMMAND_COMMAND_SET_TOOL_CHOICE:
        return set(r, m, cam_param_tool, m->tool);
    case CAMTURN_COMMAND_COMMAND_STAGE_PARAMETER_CHOICE:
        return stage(r, id, m->value);
    case CAMTURN_COMMAND_COMMAND_GET_PARAMETER_CHOICE:
        return get(r, id, cam_ok);
    case CAMTURN_COMMAND_COMMAND_GET_MINIMUM_CHOICE:
        return limit(id, true);
    case CAMTURN_COMMAND_COMMAND_GET_MAXIMUM_CHOICE:
        return limit(id, false);
    case CAMTURN_COMMAND_COMMAND_GET_REFUSAL_CHOICE:
        return get_refusal(&r->machine->refusal, m->parameter);
    default:
        return carry_out_state(r, m);
    }
}
