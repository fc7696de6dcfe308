// SPDX-License-Identifier: Apache-2.0
#include "cam_can_inner.h"
#include "cam_machine_jog.h" // cam_machine_jog

static cam_outcome_t outcome_of(cam_verdict_t verdict)
{
    return (cam_outcome_t){.err = verdict.err, .value = verdict.value};
}

/// @return position of an axis in machine coordinates
static cam_outcome_t place_of(const cam_can_t *r, hal_axis_t axis)
{
    const bool is_there = (uint32_t)axis < (uint32_t)hal_n_axes;
    return (cam_outcome_t){.err = is_there ? cam_ok : cam_err_hand_axis,
                           .value = is_there ? cam_machine_position_nm(r->machine, axis) : 0};
}

/// @return outcome of a command with one answer; cam_err_command: not of this group
static cam_outcome_t carry_out_jog(cam_can_t *r, const struct camturn_command_t *m)
{
    cam_machine_t *machine = r->machine;
    const hal_axis_t axis = (hal_axis_t)m->parameter;
    switch (m->command) {
    case CAMTURN_COMMAND_COMMAND_MANUAL_CHOICE:
        return cam_outcome(cam_machine_manual(machine));
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
    default:
        return cam_outcome(cam_err_command);
    }
}

bool cam_can_jog(cam_can_t *r, const struct camturn_command_t *m)
{
    if (m->command == CAMTURN_COMMAND_COMMAND_SET_TOOL_CHOICE) {
        cam_can_set(r, m->command, cam_param_tool, m->tool);
        return true;
    }
    const cam_outcome_t outcome = carry_out_jog(r, m);
    if (outcome.err == cam_err_command) {
        return false;
    }
    cam_can_answer(r, m->command, m->parameter, outcome);
    return true;
}
