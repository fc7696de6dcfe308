// SPDX-License-Identifier: Apache-2.0
#include "cam_can_inner.h"
#include "cam_machine.h" // cam_machine_take_command

/// Right that a command requires.
typedef enum {
    right_none,     ///< reading, and stop
    right_command,  ///< the current session
    right_unlocked, ///< the current session in the unlocked level
} right_t;

/// @return the right that a command requires: command unless it is listed
static right_t right_of(uint8_t command)
{
    switch (command) {
    case CAMTURN_COMMAND_COMMAND_STOP_CHOICE:
    case CAMTURN_COMMAND_COMMAND_GET_PARAMETER_CHOICE:
    case CAMTURN_COMMAND_COMMAND_GET_MINIMUM_CHOICE:
    case CAMTURN_COMMAND_COMMAND_GET_MAXIMUM_CHOICE:
    case CAMTURN_COMMAND_COMMAND_GET_SCOPE_CHOICE:
    case CAMTURN_COMMAND_COMMAND_READ_SCOPE_CHOICE:
    case CAMTURN_COMMAND_COMMAND_READ_SCOPE_FD_CHOICE:
    case CAMTURN_COMMAND_COMMAND_GET_LEARNED_CHOICE:
    case CAMTURN_COMMAND_COMMAND_GET_PLACE_CHOICE:
    case CAMTURN_COMMAND_COMMAND_GET_PARTS_CHOICE:
    case CAMTURN_COMMAND_COMMAND_GET_REFUSAL_CHOICE:
    case CAMTURN_COMMAND_COMMAND_STROBE_CHOICE:
    case CAMTURN_COMMAND_COMMAND_TAKE_COMMAND_CHOICE:
        return right_none;
    case CAMTURN_COMMAND_COMMAND_SELECT_TABLE_CHOICE:
    case CAMTURN_COMMAND_COMMAND_BEGIN_DOWNLOAD_CHOICE:
    case CAMTURN_COMMAND_COMMAND_END_DOWNLOAD_CHOICE:
    case CAMTURN_COMMAND_COMMAND_SET_LEARNED_CHOICE:
        return right_unlocked;
    default:
        return right_command;
    }
}

static cam_outcome_t not_commander(const cam_machine_t *machine)
{
    return (cam_outcome_t){.err = cam_err_not_commander,
                           .value = (int32_t)machine->rights.commander};
}

cam_outcome_t cam_can_admit(const cam_can_t *r, const struct camturn_command_t *m)
{
    const cam_rights_t *rights = &r->machine->rights;
    const right_t right = right_of(m->command);
    if (right == right_none || !rights->is_bus_calling) {
        return cam_outcome(cam_ok);
    }
    if (!cam_rights_is_commander(rights, m->sender, m->session)) {
        return not_commander(r->machine);
    }
    return cam_outcome(right == right_unlocked ? cam_rights_check_level(rights) : cam_ok);
}

void cam_can_hear(cam_can_t *r, const struct camturn_command_t *m)
{
    cam_rights_t *rights = &r->machine->rights;
    if (cam_rights_is_commander(rights, m->sender, m->session)) {
        cam_rights_hear(rights, cam_machine_status(r->machine).tick);
    }
}

static cam_outcome_t take_session(cam_can_t *r, const struct camturn_command_t *m)
{
    cam_machine_t *machine = r->machine;
    const cam_err_t err = cam_machine_take_command(machine, m->sender, m->is_take_over != 0u);
    if (err == cam_err_not_commander) {
        return not_commander(machine);
    }
    const int32_t session = err == cam_ok ? (int32_t)machine->rights.session : 0;
    return (cam_outcome_t){.err = err, .value = session};
}

static cam_outcome_t challenge(cam_can_t *r)
{
    uint32_t number = 0;
    const uint32_t tick = cam_machine_status(r->machine).tick;
    const cam_err_t err = cam_rights_challenge(&r->machine->rights, tick, &number);
    return (cam_outcome_t){.err = err, .value = (int32_t)number};
}

bool cam_can_rights(cam_can_t *r, const struct camturn_command_t *m)
{
    cam_outcome_t outcome = cam_outcome(cam_ok);
    switch (m->command) {
    case CAMTURN_COMMAND_COMMAND_TAKE_COMMAND_CHOICE:
        outcome = take_session(r, m);
        break;
    case CAMTURN_COMMAND_COMMAND_RELEASE_COMMAND_CHOICE:
        cam_machine_release_command(r->machine);
        break;
    case CAMTURN_COMMAND_COMMAND_HEARTBEAT_CHOICE: // cam_can_hear() does all
        break;
    case CAMTURN_COMMAND_COMMAND_GET_CHALLENGE_CHOICE:
        outcome = challenge(r);
        break;
    case CAMTURN_COMMAND_COMMAND_UNLOCK_CHOICE:
        outcome = cam_outcome(cam_rights_unlock(&r->machine->rights, m->unlock_answer,
                                                cam_machine_status(r->machine).tick));
        break;
    case CAMTURN_COMMAND_COMMAND_LOCK_CHOICE:
        cam_rights_lock(&r->machine->rights);
        break;
    default:
        return false;
    }
    cam_can_answer(r, m->command, m->parameter, outcome);
    return true;
}

bool cam_can_is_foreign_download(const cam_can_t *r)
{
    const cam_rights_t *rights = &r->machine->rights;
    const bool is_own = rights->commander != 0u && r->download_session == rights->session;
    return r->download_session != 0u && !is_own;
}
