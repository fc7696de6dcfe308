// SPDX-License-Identifier: Apache-2.0
#include "cam_can_inner.h"
#include "cam_machine.h" // cam_machine_hold
#include "cam_fix.h"     // cam_sat_i32

/// @return an error with the number of parts
static cam_outcome_t parts(const cam_can_t *r, cam_err_t err)
{
    return (cam_outcome_t){.err = err, .value = cam_sat_i32((int64_t)r->machine->n_parts)};
}

bool cam_can_cut(cam_can_t *r, const struct camturn_command_t *m)
{
    cam_machine_t *machine = r->machine;
    cam_outcome_t outcome;
    switch (m->command) {
    case CAMTURN_COMMAND_COMMAND_SET_FEED_OVERRIDE_CHOICE:
        cam_can_set(r, m->command, cam_param_feed_override_ppm, m->feed_override);
        return true;
    case CAMTURN_COMMAND_COMMAND_SET_SPINDLE_OVERRIDE_CHOICE:
        cam_can_set(r, m->command, cam_param_spindle_override_ppm, m->spindle_override);
        return true;
    case CAMTURN_COMMAND_COMMAND_SET_TRIM_CHOICE:
        cam_can_set(r, m->command, cam_param_x_trim_nm, m->trim);
        return true;
    case CAMTURN_COMMAND_COMMAND_HOLD_CHOICE:
        outcome = cam_outcome(cam_machine_hold(machine));
        break;
    case CAMTURN_COMMAND_COMMAND_RESUME_CHOICE:
        outcome = cam_outcome(cam_machine_resume(machine));
        break;
    case CAMTURN_COMMAND_COMMAND_SET_PARTS_CHOICE:
        outcome = parts(r, cam_machine_set_parts(machine, m->parts));
        break;
    case CAMTURN_COMMAND_COMMAND_GET_PARTS_CHOICE:
        outcome = parts(r, cam_ok);
        break;
    default:
        return false;
    }
    cam_can_answer(r, m->command, m->parameter, outcome);
    return true;
}
