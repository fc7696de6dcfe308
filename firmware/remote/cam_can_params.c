// SPDX-License-Identifier: Apache-2.0
#include "cam_can_inner.h"
#include "cam_fix.h" // cam_clamp_i64

/// A field of the last refusal, saturated.
static cam_outcome_t refusal(const cam_machine_t *machine, uint32_t field)
{
    const cam_refusal_t *last = &machine->refusal;
    const int64_t values[] = {
#define CAM_REFUSAL_VALUE(name, value) (int64_t)(value),
        CAM_CAN_REFUSALS(CAM_REFUSAL_VALUE)
#undef CAM_REFUSAL_VALUE
    };
    if (field >= sizeof values / sizeof values[0]) {
        return cam_outcome(cam_err_param_id);
    }
    return (cam_outcome_t){.err = cam_ok, .value = cam_sat_i32(values[field])};
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
    if (err == cam_err_param_range) {
        cam_can_answer_range(r, id);
    }
}

bool cam_can_params(cam_can_t *r, const struct camturn_command_t *m)
{
    cam_machine_t *machine = r->machine;
    cam_outcome_t outcome = cam_outcome(cam_ok);
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
        outcome = refusal(machine, m->parameter);
        break;
    default:
        return false;
    }
    cam_can_answer(r, m->command, m->parameter, outcome);
    return true;
}
