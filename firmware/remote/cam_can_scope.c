// SPDX-License-Identifier: Apache-2.0
#include "cam_can_inner.h"
#include "cam_machine_identify.h" // cam_machine_excite
#include "cam_machine_scope.h"    // cam_machine_scope_start
#include "cam_reading.h"          // cam_reading_begin

/// @return a field of the recorder with a given error
static cam_outcome_t get_scope(const cam_can_t *r, uint32_t field, cam_err_t err)
{
    cam_outcome_t outcome = cam_outcome(err);
    const cam_err_t got = cam_machine_scope_get(r->machine, field, &outcome.value);
    outcome.err = err != cam_ok ? err : got;
    return outcome;
}

static cam_outcome_t get_learned(const cam_can_t *r, uint32_t index, cam_err_t err)
{
    cam_outcome_t outcome = cam_outcome(err);
    const cam_err_t got = cam_machine_get_learned(r->machine, index, &outcome.value);
    outcome.err = err != cam_ok ? err : got;
    return outcome;
}

static cam_outcome_t excite(cam_machine_t *machine, const struct camturn_command_t *m)
{
    const cam_verdict_t verdict = cam_machine_excite(machine, m->periods, m->fade);
    return (cam_outcome_t){.err = verdict.err, .value = verdict.value};
}

/// @return outcome of a command with one answer; cam_err_command: not of this group
static cam_outcome_t carry_out_here(cam_can_t *r, const struct camturn_command_t *m)
{
    cam_machine_t *machine = r->machine;
    const uint32_t index = m->parameter;
    switch (m->command) {
    case CAMTURN_COMMAND_COMMAND_SET_SCOPE_CHOICE:
        return get_scope(r, index, cam_machine_scope_set(machine, index, m->value));
    case CAMTURN_COMMAND_COMMAND_GET_SCOPE_CHOICE:
        return get_scope(r, index, cam_ok);
    case CAMTURN_COMMAND_COMMAND_START_SCOPE_CHOICE:
        return cam_outcome(cam_machine_scope_start(machine));
    case CAMTURN_COMMAND_COMMAND_STOP_SCOPE_CHOICE:
        cam_machine_scope_stop(machine);
        return cam_outcome(cam_ok);
    case CAMTURN_COMMAND_COMMAND_RELEASE_SCOPE_CHOICE:
        return cam_outcome(cam_machine_release(machine));
    case CAMTURN_COMMAND_COMMAND_BEGIN_WAVE_CHOICE:
        return cam_can_begin_download(r, m->size, true);
    case CAMTURN_COMMAND_COMMAND_END_WAVE_CHOICE:
        return cam_can_received(r, cam_machine_wave_end(machine, m->crc));
    case CAMTURN_COMMAND_COMMAND_EXCITE_CHOICE:
        return excite(machine, m);
    case CAMTURN_COMMAND_COMMAND_KEEP_ALIVE_CHOICE:
        cam_machine_keep_alive(machine);
        return cam_outcome(cam_ok);
    case CAMTURN_COMMAND_COMMAND_GET_LEARNED_CHOICE:
        return get_learned(r, index, cam_ok);
    case CAMTURN_COMMAND_COMMAND_SET_LEARNED_CHOICE:
        return get_learned(r, index, cam_machine_set_learned(machine, index, m->value));
    default:
        return cam_outcome(cam_err_command);
    }
}

/// Begin sending a piece of the recording; the answer follows it.
static void read_scope(cam_can_t *r, const struct camturn_command_t *m)
{
    const uint32_t tick = cam_machine_status(r->machine).tick;
    const bool is_fd = m->command == CAMTURN_COMMAND_COMMAND_READ_SCOPE_FD_CHOICE;
    const uint32_t count = m->count;
    const uint32_t most = (uint32_t)cam_reading_fd_most;
    const uint32_t grains = count < most ? count : most;
    const uint32_t n_words = is_fd ? grains * (uint32_t)cam_reading_fd_grain : count;
    r->reading.parameter = m->parameter;
    const cam_err_t err =
        cam_reading_begin(&r->reading, &r->machine->scope, m->offset, n_words, is_fd, tick);
    if (err != cam_ok) {
        cam_can_answer(r, m->command, m->parameter, cam_outcome(err));
    }
}

bool cam_can_scope(cam_can_t *r, const struct camturn_command_t *m)
{
    if (m->command == CAMTURN_COMMAND_COMMAND_READ_SCOPE_CHOICE ||
        m->command == CAMTURN_COMMAND_COMMAND_READ_SCOPE_FD_CHOICE) {
        read_scope(r, m);
        return true;
    }
    const cam_outcome_t outcome = carry_out_here(r, m);
    if (outcome.err == cam_err_command) {
        return false;
    }
    cam_can_answer(r, m->command, m->parameter, outcome);
    return true;
}
