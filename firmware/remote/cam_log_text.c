// SPDX-License-Identifier: Apache-2.0
#include "cam_remote_inner.h"
#include "cam_feasible.h" // cam_derived_limits_form_pm
#include "cam_param.h"    // cam_text_number
#include <stddef.h>       // NULL

enum { max_line = 120 }; ///< longest line that hal_text() allows

typedef struct {
    char text[max_line + 1];
    uint32_t n;
} line_t;

/// Append text; the line is cut off at max_line.
static void add(line_t *line, const char *text)
{
    for (const char *at = text; *at != '\0' && line->n < max_line; at++) {
        line->text[line->n] = *at;
        line->n++;
    }
    line->text[line->n] = '\0';
}

static void say(const char *first, const char *second, const char *third, const char *fourth)
{
    line_t line = {.n = 0};
    add(&line, first);
    add(&line, second);
    add(&line, third);
    add(&line, fourth);
    hal_text(line.text);
}

void cam_log_text_start(const hal_start_t *start)
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

static void add_number(line_t *line, const char *before, uint32_t number)
{
    char text[cam_text_number_bytes];
    add(line, before);
    add(line, cam_text_number(text, number));
}

/// Report n stored parameters that are not used, by the name of the first, unless n is 0.
static void say_some(uint32_t n, const char *name, const char *what)
{
    line_t line = {.n = 0};
    if (n > 0u) {
        add_number(&line, "params: ", n);
        add(&line, what);
        add(&line, name);
        hal_text(line.text);
    }
}

static const char *name_of(cam_param_id_t id)
{
    const cam_param_info_t *info = cam_param_info(id);
    return info != NULL ? info->name : "";
}

void cam_log_text_params(const cam_machine_t *machine)
{
    const cam_param_store_found_t *kept = &machine->kept;
    if (kept->err != cam_ok) {
        say("params: ", cam_err_text(kept->err), " - defaults in use", "");
        return;
    }
    line_t line = {.n = 0};
    add_number(&line, "params: version ", kept->version);
    add(&line, kept->is_torn ? " in use, what was to be saved after it is not whole" : " in use");
    hal_text(line.text);
    say_some(kept->n_retired, "", " retired and ignored");
    say_some(kept->n_unknown, kept->unknown, " unknown to this firmware and left out, first ");
    say_some(kept->n_unfit, name_of(kept->unfit), " out of range and left at default, first ");
    say_some(kept->n_missing, name_of(kept->missing), " not among those kept, at default, first ");
}

/// Append text and picometres as nanometres with one place.
static void add_nm(line_t *line, const char *before, uint32_t pm)
{
    add_number(line, before, pm / 1000u);
    add_number(line, ".", pm % 1000u / 100u);
    add(line, " nm");
}

static void add_axis(line_t *line, const char *name, const hal_axis_scale_t *scale)
{
    add_nm(line, name, scale->command_pm);
    if (scale->most_um_per_s > 0) {
        add_number(line, " up to ", (uint32_t)scale->most_um_per_s);
        add(line, " um/s");
    }
    if (scale->measured_pm != 0u) {
        add_nm(line, ", read to ", scale->measured_pm);
    }
}

static void say_form_error(const cam_machine_t *machine)
{
    const cam_table_t *table = machine->has_table ? &machine->table : NULL;
    line_t line = {.n = 0};
    const uint32_t form_nm = cam_derived_limits_form_pm(table) / 1000u;
    const uint32_t places = form_nm % 1000u;
    add_number(&line, "form error by the steps of the outputs: ", form_nm / 1000u);
    add_number(&line, places < 10u ? ".00" : places < 100u ? ".0" : ".", places);
    add(&line, " um");
    if (table != NULL) {
        add_nm(&line, "; a count of the encoder is ",
               cam_derived_limits_count_pm(table, machine->params.counts_per_turn));
        add(&line, " of U");
    }
    hal_text(line.text);
}

void cam_log_text_scales(const cam_machine_t *machine)
{
    static const char *const names[hal_n_axes] = {
        [hal_axis_u] = "U ", [hal_axis_x] = "X ", [hal_axis_z] = "Z "};
    line_t line = {.n = 0};
    const char *before = "scales: ";
    for (uint32_t i = 0; i < (uint32_t)hal_n_axes; i++) {
        const hal_axis_scale_t scale = hal_axis_scale((hal_axis_t)i);
        if (scale.command_pm != 0u) {
            add(&line, before);
            add_axis(&line, names[i], &scale);
            before = "; ";
        }
    }
    if (line.n > 0u) {
        hal_text(line.text);
        say_form_error(machine);
    }
}

/// Report a speed of the table in use at which the encoder's counts do not average.
static void say_counts(const cam_machine_t *machine)
{
    const uint32_t set_mrpm = (uint32_t)machine->params.spindle_mrpm;
    const uint32_t of_table = machine->table.speed.knots == NULL ? machine->table.spindle_mrpm : 0u;
    const uint32_t mrpm = of_table > 0u && set_mrpm > 0u ? set_mrpm : of_table;
    const uint32_t better =
        cam_derived_limits_averaging_mrpm(&machine->params, mrpm, machine->tick_hz);
    line_t line = {.n = 0};
    if (better > 0u) {
        add_number(&line, "counts: whole ones per tick at ", mrpm / 1000u);
        add_number(&line, " r/min do not average, better ", better / 1000u);
        add(&line, " r/min");
        hal_text(line.text);
    }
}

void cam_log_text_table(cam_log_text_t *l, const cam_table_store_t *store)
{
    l->has_table = store->machine->has_table;
    if (store->err == cam_ok) {
        say("table: ", store->machine->table.name, " in use", "");
        say_counts(store->machine);
    } else {
        say("table: ", cam_err_text(store->err),
            l->has_table ? "" : " - home refused until a table is written", "");
    }
}

/// Report a change of command: a loss first, then the new commander.
static void say_command(cam_log_text_t *l, const cam_rights_t *now)
{
    line_t line = {.n = 0};
    const bool is_lost = now->n_losses != l->n_losses;
    if (is_lost) {
        add_number(&line, "command: lost, nothing was heard of ", l->commander);
    } else if (now->commander == 0u) {
        add_number(&line, "command: given up by ", l->commander);
    } else {
        add_number(&line, "command: taken by ", now->commander);
    }
    if (now->n_take_overs != l->n_take_overs) {
        add_number(&line, " over from ", l->commander);
    }
    hal_text(line.text);
    // The next call reports who took command after a loss.
    l->commander = is_lost ? 0u : now->commander;
    l->n_losses = now->n_losses;
    l->n_take_overs = now->n_take_overs;
}

/// Report a change of command, or else of the level.
static void say_rights(cam_log_text_t *l, const cam_rights_t *now)
{
    if (l->commander != now->commander || l->n_losses != now->n_losses ||
        l->n_take_overs != now->n_take_overs) {
        say_command(l, now);
    } else if (l->level != now->level) {
        l->level = now->level;
        say("level: ", l->level == cam_level_key ? "unlocked by the key switch" : "locked", "", "");
    }
}

void cam_log_text_refused(cam_log_text_t *l, uint32_t sender, uint32_t command, cam_err_t err,
                          uint32_t tick)
{
    line_t line = {.n = 0};
    const bool is_due = l->n_refused == 0u || tick - l->refused_tick >= l->refused_ticks;
    l->n_refused++;
    if (!is_due) {
        return;
    }
    l->refused_tick = tick;
    add_number(&line, "refused: command ", command);
    add_number(&line, " of ", sender);
    add(&line, ": ");
    add(&line, cam_err_text(err));
    hal_text(line.text);
}

/// Report how many counts lie between two index edges, once in a fault of the encoder that it
/// explains. @return whether it was reported
static bool say_counts_of_turn(cam_log_text_t *l, const cam_machine_t *machine,
                               const cam_status_t *status)
{
    const int32_t set = machine->params.counts_per_turn;
    const uint32_t found = cam_status_counts_found(status, l->faults, set);
    l->has_distance = l->has_distance && l->faults != 0u;
    if (l->has_distance || found == 0u) {
        return false;
    }
    line_t line = {.n = 0};
    l->has_distance = true;
    add_number(&line, "encoder: ", found);
    add_number(&line, " counts between two index edges, counts_per_turn is ", (uint32_t)set);
    hal_text(line.text);
    return true;
}

/// Report, before the first cut, a loop of U that was not measured on its drive.
/// @return whether it was reported
static bool say_loop(cam_log_text_t *l, const cam_machine_t *machine, cam_state_t state)
{
    l->has_loop = l->has_loop && state != cam_state_off;
    const bool is_due = state == cam_state_ready && !l->has_loop && hal_takes_force();
    if (!is_due || machine->params.servo_measured != 0) {
        return false;
    }
    l->has_loop = true;
    say("loop of U: not measured on its drive; run tools/tune --bus --apply", "", "", "");
    return true;
}

void cam_log_text_change(cam_log_text_t *l, cam_table_store_t *store, const cam_status_t *status)
{
    l->faults &= status->faults;
    l->is_unsteady = l->is_unsteady && store->machine->is_unsteady;
    const uint32_t unreported = status->faults & ~l->faults;
    if (l->has_table && !store->machine->has_table) {
        store->err = store->err == cam_ok ? cam_err_image_crc : store->err; // found damaged
        cam_log_text_table(l, store);
    } else if (l->state != status->state) {
        l->state = status->state;
        say("state ", cam_state_name(status->state), "", "");
    } else if (store->machine->is_unsteady && !l->is_unsteady) {
        l->is_unsteady = true;
        say("start ended: the spindle does not turn steadily, check its drive", "", "", "");
    } else if (unreported != 0u) {
        uint32_t i = 0;
        while ((unreported >> i & 1u) == 0u) {
            i++;
        }
        say("fault ", cam_fault_name((cam_fault_t)i), ": ", cam_fault_text((cam_fault_t)i));
        l->faults |= UINT32_C(1) << i;
    } else if (!say_counts_of_turn(l, store->machine, status) &&
               !say_loop(l, store->machine, status->state)) {
        say_rights(l, &store->machine->rights);
    }
}
