// SPDX-License-Identifier: Apache-2.0
#include "cam_lines.h"

enum { max_line = 120 }; ///< longest line that hal_text() allows

/// A line that is being put together.
typedef struct {
    char text[max_line + 1];
    uint32_t n;
} line_t;

/// Append text; what does not fit is cut off.
static void add(line_t *line, const char *text)
{
    for (const char *at = text; *at != '\0' && line->n < max_line; at++) {
        line->text[line->n] = *at;
        line->n++;
    }
    line->text[line->n] = '\0';
}

/// Write four pieces of text as one line.
static void say(const char *first, const char *second, const char *third, const char *fourth)
{
    line_t line = {.n = 0};
    add(&line, first);
    add(&line, second);
    add(&line, third);
    add(&line, fourth);
    hal_text(line.text);
}

void cam_lines_start(const hal_start_t *start)
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

void cam_lines_table(cam_lines_t *l, const cam_store_t *store)
{
    l->has_table = store->machine->has_table;
    if (store->err == cam_ok) {
        say("table: ", store->machine->table.name, " in use", "");
    } else {
        say("table: ", cam_err_text(store->err),
            l->has_table ? "" : " - home refused until a table is written", "");
    }
}

/// Report the first of the faults that have not been reported.
static void say_fault(cam_lines_t *l, uint32_t unreported)
{
    uint32_t i = 0;
    while ((unreported >> i & 1u) == 0u) {
        i++;
    }
    say("fault ", cam_fault_name((cam_fault_t)i), ": ", cam_fault_text((cam_fault_t)i));
    l->faults |= UINT32_C(1) << i;
}

void cam_lines_change(cam_lines_t *l, cam_store_t *store, const cam_status_t *status)
{
    l->faults &= status->faults;
    const uint32_t unreported = status->faults & ~l->faults;
    if (l->has_table && !store->machine->has_table) {
        store->err = store->err == cam_ok ? cam_err_image_crc : store->err; // found damaged
        cam_lines_table(l, store);
    } else if (l->state != status->state) {
        l->state = status->state;
        say("state ", cam_state_name(status->state), "", "");
    } else if (unreported != 0u) {
        say_fault(l, unreported);
    }
}
