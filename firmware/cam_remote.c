// SPDX-License-Identifier: Apache-2.0
#include "cam/cam_remote.h"
#include "cam/cam_fix.h" // cam_sat_i32
#include <stddef.h>      // NULL

enum { frame_bytes = 8 };

enum { status_hz = 100 };

/// Frames with foreign ids that one poll passes over.
enum { max_foreign = 8 };

/// Offset of the image's size in its header, TABLE_FORMAT.md.
enum { at_image_size = 16 };

// Bytes

static uint32_t get_u32(const uint8_t *bytes)
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
           (uint32_t)bytes[3] << 24;
}

static void put_u16(uint8_t *bytes, uint32_t value)
{
    bytes[0] = (uint8_t)(value & 0xFFu);
    bytes[1] = (uint8_t)(value >> 8 & 0xFFu);
}

static void put_u32(uint8_t *bytes, uint32_t value)
{
    put_u16(bytes, value);
    put_u16(bytes + 2, value >> 16);
}

// Lines for people

enum { max_line = 120 }; ///< as hal_text() allows

typedef struct {
    char text[max_line + 1];
    uint32_t n;
} line_t;

static void add(line_t *line, const char *text)
{
    for (const char *at = text; *at != '\0' && line->n < max_line; at++) {
        line->text[line->n] = *at;
        line->n++;
    }
    line->text[line->n] = '\0';
}

/// Write the words one behind the other; what does not fit is cut off.
static void say(const char *first, const char *second, const char *third, const char *fourth)
{
    line_t line = {.n = 0};
    add(&line, first);
    add(&line, second);
    add(&line, third);
    add(&line, fourth);
    hal_text(line.text);
}

static void say_start(const hal_start_t *start)
{
    static const char *const reasons[hal_reset_brown_out + 1] = {
        [hal_reset_power_on] = "power on",       [hal_reset_pin] = "reset pin",
        [hal_reset_software] = "software reset", [hal_reset_halt] = "halt",
        [hal_reset_watchdog] = "watchdog reset", [hal_reset_brown_out] = "brown-out reset",
    };
    const bool is_known = (uint32_t)start->reset < sizeof reasons / sizeof reasons[0];
    const char *reason = is_known ? reasons[start->reset] : "unknown reset";
    say("start: ", reason, start->why[0] != '\0' ? ": " : "", start->why);
}

static void say_table(cam_remote_t *r)
{
    r->has_table = r->machine->has_table;
    if (r->table_err == cam_ok) {
        say("table: ", r->machine->table.name, " in use", "");
    } else {
        say("table: ", cam_err_text(r->table_err),
            r->has_table ? "" : " - home refused until a table is written", "");
    }
}

/// A table that was there is gone: the background check found it damaged.
static void say_loss(cam_remote_t *r)
{
    if (r->table_err == cam_ok) {
        r->table_err = cam_err_image_crc;
    }
    say_table(r);
}

static void say_fault(cam_remote_t *r, uint32_t untold)
{
    uint32_t i = 0;
    while ((untold >> i & 1u) == 0u) {
        i++;
    }
    say("fault ", cam_fault_name((cam_fault_t)i), ": ", cam_fault_text((cam_fault_t)i));
    r->faults |= UINT32_C(1) << i;
}

/// One line per poll, so that a slow serial line does not hold up the rest.
static void say_change(cam_remote_t *r, const cam_status_t *status)
{
    r->faults &= status->faults;
    const uint32_t untold = status->faults & ~r->faults;
    if (r->has_table && !r->machine->has_table) {
        say_loss(r);
    } else if (r->state != status->state) {
        r->state = status->state;
        say("state ", cam_state_name(status->state), "", "");
    } else if (untold != 0u) {
        say_fault(r, untold);
    }
}

// Table

/// @return [bytes] of the image at a place, which may be larger: as the header tells, the whole
/// place when that cannot be; cam_table_check() then finds what is wrong
static uint32_t image_size(const hal_image_t *place)
{
    if (place->size < cam_table_header_size) {
        return place->size;
    }
    const uint32_t size = get_u32((const uint8_t *)place->bytes + at_image_size);
    return size >= cam_table_header_size && size < place->size ? size : place->size;
}

static cam_err_t select_table(cam_remote_t *r)
{
    const hal_image_t place = hal_table_image();
    if (place.bytes == NULL || place.size == 0u) {
        return cam_err_no_table;
    }
    return cam_machine_select_table(r->machine, place.bytes, image_size(&place));
}

/// @return true when an error tells of the moment, not of the table
static bool is_too_early(cam_err_t err)
{
    return err == cam_err_state || err == cam_err_busy;
}

static cam_err_t select_and_say(cam_remote_t *r)
{
    const cam_err_t err = select_table(r);
    if (!is_too_early(err)) {
        r->table_err = err;
        say_table(r);
    }
    return err;
}

// Commands

typedef struct {
    cam_err_t err;
    int32_t value;
} outcome_t;

/// A refusal for want of a table tells why there is none, an infeasible speed which one would do.
static outcome_t explained(const cam_remote_t *r, cam_err_t err)
{
    if (err == cam_err_no_table) {
        return (outcome_t){.err = r->table_err};
    }
    const cam_feasibility_t why = cam_machine_feasibility(r->machine, 0);
    const bool is_infeasible = err != cam_ok && err == why.err;
    return (outcome_t){.err = err, .value = is_infeasible ? cam_sat_i32(why.highest_mrpm) : 0};
}

static outcome_t with_value(const cam_remote_t *r, cam_param_id_t id, cam_err_t err)
{
    const bool is_there = cam_param_info(id) != NULL;
    return (outcome_t){.err = is_there ? err : cam_err_param_id,
                       .value = is_there ? cam_param_get(&r->machine->params, id) : 0};
}

static outcome_t plain(cam_err_t err)
{
    return (outcome_t){.err = err};
}

static outcome_t carry_out(cam_remote_t *r, const uint8_t *data)
{
    cam_machine_t *m = r->machine;
    const cam_param_id_t id = (cam_param_id_t)data[1];
    switch (data[0]) {
    case cam_remote_enable:
        return explained(r, cam_machine_enable(m));
    case cam_remote_disable:
        return plain(cam_machine_disable(m));
    case cam_remote_start:
        return explained(r, cam_machine_start(m));
    case cam_remote_stop:
        return plain(cam_machine_stop(m));
    case cam_remote_reset:
        return plain(cam_machine_reset(m));
    case cam_remote_set:
        return with_value(r, id, cam_machine_set_param(m, id, (int32_t)get_u32(data + 4)));
    case cam_remote_get:
        return with_value(r, id, cam_ok);
    case cam_remote_select:
        return plain(select_and_say(r));
    default:
        return plain(cam_err_command);
    }
}

static bool is_well_formed(const hal_can_frame_t *frame)
{
    return frame->n == frame_bytes && frame->data[2] == 0u && frame->data[3] == 0u;
}

static void answer(cam_remote_t *r, const hal_can_frame_t *command)
{
    const outcome_t outcome =
        is_well_formed(command) ? carry_out(r, command->data) : plain(cam_err_frame);
    r->answer = (hal_can_frame_t){.id = cam_remote_id_answer, .n = frame_bytes};
    for (uint32_t i = 0; i < 2u && i < command->n; i++) {
        r->answer.data[i] = command->data[i];
    }
    put_u16(r->answer.data + 2, (uint32_t)outcome.err);
    put_u32(r->answer.data + 4, (uint32_t)outcome.value);
    r->has_answer = true;
}

/// @return true when a command was received
static bool read_command(hal_can_frame_t *frame)
{
    for (uint32_t i = 0; i < max_foreign && hal_can_read(frame); i++) {
        if (frame->id == cam_remote_id_command) {
            return true;
        }
    }
    return false;
}

static void send_answer(cam_remote_t *r)
{
    r->has_answer = r->has_answer && !hal_can_write(&r->answer);
}

static void serve(cam_remote_t *r)
{
    hal_can_frame_t frame;
    send_answer(r);
    if (!r->has_answer && read_command(&frame)) {
        answer(r, &frame);
        send_answer(r);
    }
}

// Status

/// @return [r/min / 1000] rounded to nearest, saturated; 60 000 = 1875 * 2^5
static int32_t speed_mrpm(int32_t speed_q32, uint32_t tick_hz)
{
    const int64_t mrpm_q27 = (int64_t)speed_q32 * tick_hz * 1875;
    return cam_sat_i32((mrpm_q27 + (INT64_C(1) << 26)) >> 27);
}

static void send(uint32_t id, uint32_t first, uint32_t second)
{
    hal_can_frame_t frame = {.id = id, .n = frame_bytes};
    put_u32(frame.data, first);
    put_u32(frame.data + 4, second);
    (void)hal_can_write(&frame); // the next one tells what this one could not
}

static void send_status(const cam_remote_t *r, const cam_status_t *status)
{
    const uint32_t words = (uint32_t)status->state | ((uint32_t)r->start.reset & 0xFFu) << 8 |
                           (uint32_t)r->table_err << 16;
    send(cam_remote_id_state, words, status->faults);
    send(cam_remote_id_motion, (uint32_t)speed_mrpm(status->speed_q32, r->machine->tick_hz),
         (uint32_t)status->z_nm);
    send(cam_remote_id_load, hal_load().max_cycles, status->n_late);
}

/// The rate holds on average; periods that nobody polled in are skipped.
static void send_when_due(cam_remote_t *r, const cam_status_t *status)
{
    const uint32_t period = r->machine->tick_hz / status_hz;
    if (status->tick - r->status_tick < period) {
        return;
    }
    r->status_tick += period;
    if (status->tick - r->status_tick >= period) {
        r->status_tick = status->tick;
    }
    send_status(r, status);
}

void cam_remote_init(cam_remote_t *r, cam_machine_t *machine)
{
    *r = (cam_remote_t){.machine = machine, .start = hal_start(), .table_err = cam_err_no_table};
    say_start(&r->start);
    (void)select_and_say(r);
}

void cam_remote_poll(cam_remote_t *r)
{
    serve(r);
    const cam_status_t status = cam_machine_status(r->machine);
    send_when_due(r, &status);
    say_change(r, &status);
}
