// SPDX-License-Identifier: Apache-2.0
#include "cam_remote_inner.h"
#include "cam_machine.h" // cam_machine_wave_block
#include "camturn.h"     // camturn_command_unpack

/// Offsets of command and parameter in a frame. They are echoed even if the frame is too short.
enum { at_command, at_parameter, n_echoed };

/// Frames that one call of cam_can_poll() reads at most.
enum { max_frames = 8 };

// Answers

/// The command selects the signal that carries the value: all are set, and the generated pack
/// function uses one. There is room for cam_can_max_answers.
static void answer(cam_can_t *r, uint8_t command, uint8_t parameter, cam_outcome_t outcome)
{
    const struct camturn_answer_t m = {
        .command = command,
        .parameter = parameter,
        .result = (int16_t)outcome.err,
        .highest_speed = outcome.value,
        .value = outcome.value,
        .minimum = outcome.value,
        .maximum = outcome.value,
        .parts = outcome.value,
        .received = (uint32_t)outcome.value,
        .crc = (uint32_t)outcome.value,
        .jog_speed = outcome.value,
        .place = outcome.value,
        .datum = outcome.value,
    };
    hal_can_frame_t *frame = &r->answers[r->n_answers];
    frame->id = CAMTURN_ANSWER_FRAME_ID;
    frame->n = (uint32_t)camturn_answer_pack(frame->data, &m, sizeof frame->data);
    r->n_answers++;
}

/// Send the queued answers.
/// @return whether all fitted the transmit queue
static bool send_answers(cam_can_t *r)
{
    while (r->n_answered < r->n_answers && hal_can_write(&r->answers[r->n_answered])) {
        r->n_answered++;
    }
    if (r->n_answered < r->n_answers) {
        return false;
    }
    r->n_answered = 0;
    r->n_answers = 0;
    return true;
}

// Commands

static void hear(cam_can_t *r, const struct camturn_command_t *m)
{
    cam_rights_t *rights = &r->machine->rights;
    if (cam_rights_is_commander(rights, m->sender, m->session)) {
        cam_rights_hear(rights, cam_status_tick(r->machine->core));
    }
}

/// Execute a command if its sender may give it, and answer it. The commander counts as heard again
/// at the end: a long command does not cost it command, though its next frame waits.
static void give(cam_can_t *r, const struct camturn_command_t *m)
{
    cam_rights_t *rights = &r->machine->rights;
    rights->is_bus_calling = true;
    hear(r, m);
    const cam_err_t refusal = cam_can_admit(rights, m);
    cam_outcome_t outcome = refusal == cam_ok ? cam_can_carry_out(r, m) : cam_outcome(refusal);
    if (outcome.err == cam_err_not_commander) {
        outcome.value = (int32_t)rights->commander;
    }
    if (!outcome.is_deferred) {
        answer(r, m->command, m->parameter, outcome);
    }
    if (outcome.has_range) {
        answer(r, CAMTURN_ANSWER_COMMAND_GET_MINIMUM_CHOICE, m->parameter,
               (cam_outcome_t){.value = outcome.min});
        answer(r, CAMTURN_ANSWER_COMMAND_GET_MAXIMUM_CHOICE, m->parameter,
               (cam_outcome_t){.value = outcome.max});
    }
    if (refusal != cam_ok) {
        cam_log_text_refused(&r->lines, m->sender, m->command, refusal,
                             cam_status_tick(r->machine->core));
    }
    hear(r, m);
    rights->is_bus_calling = false;
}

static void take_command(cam_can_t *r, const hal_can_frame_t *frame)
{
    struct camturn_command_t m = {.command = 0};
    const bool is_whole = frame->n == CAMTURN_COMMAND_LENGTH &&
                          camturn_command_unpack(&m, frame->data, frame->n) == 0;
    if (is_whole) {
        give(r, &m);
        return;
    }
    // Echo the bytes of a malformed frame, so that its sender recognises the answer.
    uint8_t echo[n_echoed] = {0};
    for (uint32_t i = 0; i < n_echoed && i < frame->n; i++) {
        echo[i] = frame->data[i];
    }
    answer(r, echo[at_command], echo[at_parameter], cam_outcome(cam_err_frame));
}

// Downloads

/// Store a block of the download that was begun last.
static cam_err_t store_block(cam_can_t *r, uint32_t n)
{
    const uint8_t *b = r->block;
    const cam_rights_t *rights = &r->machine->rights;
    const bool is_own = rights->commander != 0u && r->download_session == rights->session;
    if (r->download_session != 0u && !is_own) { // begun by another session than the current one
        return cam_err_not_commander;
    }
    if (!r->is_wave) {
        return cam_table_store_block(&r->store, b, n);
    }
    if (n <= cam_table_store_block_header) {
        return cam_err_download_order;
    }
    return cam_machine_wave_block(r->machine, cam_table_store_word(b),
                                  &b[cam_table_store_block_header],
                                  n - cam_table_store_block_header);
}

static void end_block(cam_can_t *r, cam_isotp_event_t event)
{
    if (event != cam_isotp_nothing) {
        const cam_err_t err =
            event == cam_isotp_message ? store_block(r, r->isotp.length) : cam_err_download_order;
        answer(r, CAMTURN_ANSWER_COMMAND_DOWNLOAD_BLOCK_CHOICE, 0, cam_can_received(r, err));
    }
}

/// Send a pending flow control.
/// @return whether none is left
static bool send_flow(cam_can_t *r)
{
    hal_can_frame_t frame = {.id = CAMTURN_BLOCK_FLOW_FRAME_ID};
    r->isotp.has_flow = cam_isotp_flow(&r->isotp, &frame) && !hal_can_write(&frame);
    return !r->isotp.has_flow;
}

// The loop

/// @return whether a command may arrive while a piece is sent without ending it
static bool is_allowed_while_reading(const hal_can_frame_t *frame)
{
    return frame->n > 0u && frame->data[at_command] == CAMTURN_COMMAND_COMMAND_HEARTBEAT_CHOICE;
}

/// Take a frame. Any command but heartbeat, and any block, ends the piece of a recording that is
/// being sent.
/// @return false when a pending message did not fit
static bool take_frame(cam_can_t *r, const hal_can_frame_t *frame, uint32_t tick)
{
    if (frame->id == CAMTURN_COMMAND_FRAME_ID) {
        r->reading.is_on = r->reading.is_on && is_allowed_while_reading(frame);
        take_command(r, frame);
    } else if (frame->id == CAMTURN_BLOCK_FRAME_ID) {
        r->reading.is_on = false;
        end_block(r, cam_isotp_receive(&r->isotp, frame, tick));
    } else {
        return true;
    }
    return send_flow(r);
}

/// Continue sending a piece of the recording, and answer after its end.
static void continue_reading(cam_can_t *r, uint32_t tick)
{
    const cam_scope_t *scope = &r->machine->scope;
    const cam_reading_event_t event = cam_reading_poll(&r->reading, scope, tick);
    if (event != cam_reading_nothing) {
        const bool is_lost = event == cam_reading_lost;
        const cam_outcome_t outcome = {
            .err = is_lost ? cam_err_scope_range : cam_ok,
            .value = is_lost ? 0 : (int32_t)cam_reading_crc(&r->reading, scope),
        };
        const uint8_t command = r->reading.is_fd ? CAMTURN_ANSWER_COMMAND_READ_SCOPE_FD_CHOICE
                                                 : CAMTURN_ANSWER_COMMAND_READ_SCOPE_CHOICE;
        answer(r, command, r->reading.parameter, outcome);
    }
}

/// Read frames until one needs an answer: at most one command or block per call.
static void serve(cam_can_t *r, uint32_t tick)
{
    hal_can_frame_t frame;
    if (!send_answers(r) || !send_flow(r)) {
        return;
    }
    continue_reading(r, tick);
    bool is_free = r->n_answers == 0u;
    for (uint32_t i = 0; i < max_frames && is_free && hal_can_read(&frame); i++) {
        is_free = take_frame(r, &frame, tick) && r->n_answers == 0u;
    }
    if (is_free) { // check whether the next frame of a block is overdue
        end_block(r, cam_isotp_wait(&r->isotp, tick));
    }
    (void)send_answers(r);
}

void cam_can_init(cam_can_t *r, cam_machine_t *machine)
{
    *r = (cam_can_t){
        .machine = machine,
        .store = {.machine = machine, .err = cam_err_no_table},
        .report.start = hal_start(),
        .lines.refused_ticks = machine->tick_hz,
        .isotp = {.bytes = r->block,
                  .capacity = sizeof r->block,
                  .timeout_ticks = machine->tick_hz},
    };
    cam_log_text_start(&r->report.start);
    cam_log_text_params(machine);
    (void)cam_can_select(r);
    cam_log_text_scales(machine);
}

void cam_can_poll(cam_can_t *r)
{
    serve(r, cam_status_tick(r->machine->core));
    const cam_status_t status = cam_machine_status(r->machine);
    cam_report_send(&r->report, &r->store, &status);
    cam_log_text_change(&r->lines, &r->store, &status);
}
