// SPDX-License-Identifier: Apache-2.0
#include "cam_can_inner.h"
#include "cam_fix.h" // cam_sat_i32

/// @return a field of a refusal, with units as in cam_feasibility_t
static int64_t field_of(const cam_refusal_t *last, uint32_t field)
{
    switch (field) {
    case cam_refusal_result:
        return (int64_t)last->why.err;
    case cam_refusal_needed:
        return last->why.needed;
    case cam_refusal_limit:
        return last->why.limit;
    case cam_refusal_highest_mrpm:
        return (int64_t)last->why.highest_mrpm;
    case cam_refusal_largest_feed_nm:
        return (int64_t)last->why.largest_feed_nm;
    case cam_refusal_pass:
        return (int64_t)last->why.pass;
    default:
        return (int64_t)last->param;
    }
}

/// @return a field of the last refusal, saturated
static cam_outcome_t get_refusal(const cam_machine_t *machine, uint32_t field)
{
    if (field >= (uint32_t)cam_n_refusals) {
        return cam_outcome(cam_err_param_id);
    }
    return (cam_outcome_t){.err = cam_ok, .value = cam_sat_i32(field_of(&machine->refusal, field))};
}

/// @return a result with the version of the parameters in force
static cam_outcome_t with_version(const cam_machine_t *machine, cam_err_t err)
{
    return (cam_outcome_t){.err = err, .value = (int32_t)machine->version};
}

static void stage(cam_can_t *r, const struct camturn_command_t *m)
{
    const cam_param_id_t id = (cam_param_id_t)m->parameter;
    const cam_err_t err = cam_machine_stage(r->machine, id, m->value);
    const int32_t value = err != cam_err_param_id && err != cam_err_params_begin
                              ? cam_param_get(&r->machine->staged, id)
                              : 0;
    cam_can_answer(r, m->command, m->parameter, (cam_outcome_t){.err = err, .value = value});
    if (err == cam_err_param_range || err == cam_err_hard_limit) {
        cam_can_answer_range(r, id);
    }
}

bool cam_can_params(cam_can_t *r, const struct camturn_command_t *m)
{
    cam_machine_t *machine = r->machine;
    cam_outcome_t outcome;
    switch (m->command) {
    case CAMTURN_COMMAND_COMMAND_BEGIN_PARAMETERS_CHOICE:
        cam_machine_stage_begin(machine);
        outcome = with_version(machine, cam_ok);
        break;
    case CAMTURN_COMMAND_COMMAND_STAGE_PARAMETER_CHOICE:
        stage(r, m);
        return true;
    case CAMTURN_COMMAND_COMMAND_COMMIT_PARAMETERS_CHOICE:
        outcome = with_version(machine, cam_machine_stage_commit(machine));
        break;
    case CAMTURN_COMMAND_COMMAND_SAVE_PARAMETERS_CHOICE:
        outcome = with_version(machine, cam_machine_save_params(machine));
        break;
    case CAMTURN_COMMAND_COMMAND_RESTORE_DEFAULTS_CHOICE:
        outcome = with_version(machine, cam_machine_restore_defaults(machine));
        break;
    case CAMTURN_COMMAND_COMMAND_REVERT_PARAMETERS_CHOICE:
        outcome = with_version(machine, cam_machine_revert_params(machine));
        break;
    case CAMTURN_COMMAND_COMMAND_GET_REFUSAL_CHOICE:
        outcome = get_refusal(machine, m->parameter);
        break;
    default:
        return false;
    }
    cam_can_answer(r, m->command, m->parameter, outcome);
    return true;
}
