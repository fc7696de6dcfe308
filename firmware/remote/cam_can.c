// SPDX-License-Identifier: Apache-2.0
#include "cam_can.h"
#include "cam_can_inner.h"        // cam_can_scope
#include "cam_fix.h"              // cam_sat_i32
#include "cam_machine_identify.h" // cam_machine_wave_begin
#include "camturn.h"              // camturn_command_unpack
#include <stddef.h>               // NULL

/// Offsets of command and parameter in a frame. They are echoed even if the frame is too short.
enum { at_command, at_parameter, n_echoed };

/// Frames that one call of cam_can_poll() reads at most.
enum { max_frames = 8 };

// Answers

/// The command selects the signal that carries the value: all are set, and the generated pack
/// function uses one.
void cam_can_answer(cam_can_t *r, uint8_t command, uint8_t parameter, cam_outcome_t outcome)
{
    const struct camturn_answer_t m = {
        .command = command,
        .parameter = parameter,
        .result = (int16_t)outcome.err,
        .highest_speed = outcome.value,
        .value = outcome.value,
        .minimum = outcome.value,
        .maximum = outcome.value,
        .speed = outcome.value,
        .feed = outcome.value,
        .amplitude = outcome.value,
        .phase = outcome.value,
        .feed_override = outcome.value,
        .spindle_override = outcome.value,
        .trim = outcome.value,
        .parts = outcome.value,
        .received = (uint32_t)outcome.value,
        .crc = (uint32_t)outcome.value,
        .jog_speed = outcome.value,
        .place = outcome.value,
        .datum = outcome.value,
        .tool = outcome.value,
        .challenge = (uint32_t)outcome.value,
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

// Parameters

/// @return the value in force, with a given error unless the parameter does not exist
static cam_outcome_t get(const cam_can_t *r, cam_param_id_t id, cam_err_t err)
{
    const bool is_there = cam_param_info(id) != NULL;
    return (cam_outcome_t){.err = is_there ? err : cam_err_param_id,
                           .value = is_there ? cam_param_get(&r->machine->params, id) : 0};
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

void cam_can_answer_range(cam_can_t *r, cam_param_id_t id)
{
    const uint8_t index = (uint8_t)id;
    cam_can_answer(r, CAMTURN_ANSWER_COMMAND_GET_MINIMUM_CHOICE, index, limit(id, true));
    cam_can_answer(r, CAMTURN_ANSWER_COMMAND_GET_MAXIMUM_CHOICE, index, limit(id, false));
}

void cam_can_set(cam_can_t *r, uint8_t command, cam_param_id_t id, int32_t value)
{
    const uint8_t index = (uint8_t)id;
    const cam_outcome_t outcome = get(r, id, cam_machine_set_param(r->machine, id, value));
    cam_can_answer(r, command, index, outcome);
    if (outcome.err == cam_err_param_range || outcome.err == cam_err_hard_limit) {
        cam_can_answer_range(r, id);
    }
}

// Commands

/// Select the table and report it in a line of text, unless the error is temporary.
static cam_err_t select_and_report(cam_can_t *r)
{
    const cam_err_t err = cam_table_store_select(&r->store);
    if (!cam_table_store_is_of_moment(err)) {
        cam_log_text_table(&r->lines, &r->store);
    }
    return err;
}

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

cam_outcome_t cam_can_received(const cam_can_t *r, cam_err_t err)
{
    const uint32_t n = r->is_wave ? cam_machine_wave_received(r->machine) : r->store.received;
    return (cam_outcome_t){.err = err, .value = (int32_t)n};
}

cam_outcome_t cam_can_begin_download(cam_can_t *r, uint32_t size, bool is_wave)
{
    r->is_wave = is_wave;
    r->download_session = r->machine->rights.session;
    return cam_can_received(r, is_wave ? cam_machine_wave_begin(r->machine, size)
                                       : cam_table_store_begin(&r->store, size));
}

/// Execute a command that has exactly one answer.
static cam_outcome_t carry_out(cam_can_t *r, const struct camturn_command_t *m)
{
    const cam_param_id_t id = (cam_param_id_t)m->parameter;
    switch (m->command) {
    case CAMTURN_COMMAND_COMMAND_ENABLE_CHOICE:
        return explained(r, cam_machine_enable(r->machine));
    case CAMTURN_COMMAND_COMMAND_HOME_CHOICE:
        return explained(r, cam_machine_home(r->machine));
    case CAMTURN_COMMAND_COMMAND_DISABLE_CHOICE:
        return cam_outcome(cam_machine_disable(r->machine));
    case CAMTURN_COMMAND_COMMAND_START_CHOICE:
        return explained(r, cam_machine_start(r->machine));
    case CAMTURN_COMMAND_COMMAND_STOP_CHOICE:
        return cam_outcome(cam_machine_stop(r->machine));
    case CAMTURN_COMMAND_COMMAND_RESET_CHOICE:
        return cam_outcome(cam_machine_reset(r->machine));
    case CAMTURN_COMMAND_COMMAND_GET_PARAMETER_CHOICE:
        return get(r, id, cam_ok);
    case CAMTURN_COMMAND_COMMAND_GET_MINIMUM_CHOICE:
        return limit(id, true);
    case CAMTURN_COMMAND_COMMAND_GET_MAXIMUM_CHOICE:
        return limit(id, false);
    case CAMTURN_COMMAND_COMMAND_SELECT_TABLE_CHOICE:
        return cam_outcome(select_and_report(r));
    case CAMTURN_COMMAND_COMMAND_BEGIN_DOWNLOAD_CHOICE:
        return cam_can_begin_download(r, m->size, false);
    case CAMTURN_COMMAND_COMMAND_END_DOWNLOAD_CHOICE:
        return cam_can_received(r, cam_table_store_end(&r->store, m->crc));
    default:
        return cam_outcome(cam_err_command);
    }
}

/// Execute a command and answer it. Setting a parameter may take several answers.
static void follow(cam_can_t *r, const struct camturn_command_t *m)
{
    switch (m->command) {
    case CAMTURN_COMMAND_COMMAND_SET_PARAMETER_CHOICE:
        cam_can_set(r, m->command, (cam_param_id_t)m->parameter, m->value);
        break;
    case CAMTURN_COMMAND_COMMAND_SET_SPEED_CHOICE:
        cam_can_set(r, m->command, cam_param_spindle_mrpm, m->speed);
        break;
    case CAMTURN_COMMAND_COMMAND_SET_FEED_CHOICE:
        cam_can_set(r, m->command, cam_param_feed_nm, m->feed);
        break;
    case CAMTURN_COMMAND_COMMAND_SET_AMPLITUDE_CHOICE:
        cam_can_set(r, m->command, cam_param_amplitude_ppm, m->amplitude);
        break;
    case CAMTURN_COMMAND_COMMAND_SET_PHASE_CHOICE:
        cam_can_set(r, m->command, cam_param_phase_udeg, m->phase);
        break;
    default:
        if (!cam_can_scope(r, m) && !cam_can_params(r, m) && !cam_can_jog(r, m) &&
            !cam_can_cut(r, m) && !cam_can_strobe(r, m) && !cam_can_rights(r, m)) {
            cam_can_answer(r, m->command, m->parameter, carry_out(r, m));
        }
        break;
    }
}

/// Execute a command if its sender may give it. The commander counts as heard again at the end: a
/// long command does not cost it command, though its next frame waits.
static void give(cam_can_t *r, const struct camturn_command_t *m)
{
    cam_rights_t *rights = &r->machine->rights;
    rights->is_bus_calling = true;
    cam_can_hear(r, m);
    const cam_outcome_t refused = cam_can_admit(r, m);
    if (refused.err == cam_ok) {
        follow(r, m);
    } else {
        cam_can_answer(r, m->command, m->parameter, refused);
        cam_log_text_refused(&r->lines, m->sender, m->command, refused.err,
                             cam_machine_status(r->machine).tick);
    }
    cam_can_hear(r, m);
    rights->is_bus_calling = false;
}

/// Check the form of a command frame, then execute it.
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
    cam_can_answer(r, echo[at_command], echo[at_parameter], cam_outcome(cam_err_frame));
}

// Downloads

/// Store a block of the download that was begun last.
static cam_err_t store_block(cam_can_t *r, uint32_t n)
{
    const uint8_t *b = r->block;
    if (cam_can_is_foreign_download(r)) {
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

/// Store a complete block, or report a lost one.
static void end_block(cam_can_t *r, cam_isotp_event_t event)
{
    if (event != cam_isotp_nothing) {
        const cam_err_t err =
            event == cam_isotp_message ? store_block(r, r->isotp.length) : cam_err_download_order;
        cam_can_answer(r, CAMTURN_ANSWER_COMMAND_DOWNLOAD_BLOCK_CHOICE, 0,
                       cam_can_received(r, err));
    }
}

/// Send a pending flow control.
/// @return whether none is left
static bool send_flow(cam_can_t *r)
{
    hal_can_frame_t frame = {.id = CAMTURN_BLOCK_FLOW_FRAME_ID};
    if (cam_isotp_flow(&r->isotp, &frame)) {
        if (!hal_can_write(&frame)) {
            return false;
        }
        cam_isotp_flow_sent(&r->isotp);
    }
    return true;
}

// The loop

/// Take a frame. Any command but strobe, and any block, ends the piece of a recording that is being
/// sent.
/// @return false when a pending message did not fit
static bool take_frame(cam_can_t *r, const hal_can_frame_t *frame, uint32_t tick)
{
    if (frame->id == CAMTURN_COMMAND_FRAME_ID) {
        const bool is_strobe =
            frame->n > 0u && frame->data[at_command] == CAMTURN_COMMAND_COMMAND_STROBE_CHOICE;
        r->reading.is_on = r->reading.is_on && is_strobe;
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
        cam_can_answer(r, command, r->reading.parameter, outcome);
    }
}

/// Read frames until one needs an answer: at most one command or block per call.
/// @return whether nothing waits for the transmit queue
static bool serve(cam_can_t *r, uint32_t tick)
{
    hal_can_frame_t frame;
    if (!send_answers(r) || !send_flow(r)) {
        return false;
    }
    continue_reading(r, tick);
    bool is_free = r->n_answers == 0u;
    for (uint32_t i = 0; i < max_frames && is_free && hal_can_read(&frame); i++) {
        is_free = take_frame(r, &frame, tick) && r->n_answers == 0u;
    }
    if (is_free) { // check whether the next frame of a block is overdue
        end_block(r, cam_isotp_wait(&r->isotp, tick));
    }
    return send_answers(r);
}

void cam_can_init(cam_can_t *r, cam_machine_t *machine)
{
    *r = (cam_can_t){.machine = machine, .report.start = hal_start()};
    r->isotp = (cam_isotp_t){
        .bytes = r->block, .capacity = sizeof r->block, .timeout_ticks = machine->tick_hz};
    r->lines.refused_ticks = machine->tick_hz;
    cam_table_store_init(&r->store, machine);
    cam_log_text_start(&r->report.start);
    cam_log_text_params(machine);
    (void)select_and_report(r);
    cam_log_text_scales(machine);
}

void cam_can_poll(cam_can_t *r)
{
    const bool is_idle = serve(r, cam_machine_status(r->machine).tick);
    const cam_status_t status = cam_machine_status(r->machine);
    cam_report_send(&r->report, &r->store, &status);
    if (is_idle) { // a live picture waits for everything else
        cam_can_send_sample(r, status.tick);
    }
    cam_log_text_change(&r->lines, &r->store, &status);
}
