// SPDX-License-Identifier: Apache-2.0
#include "camsim.h"
#include "common_number.h" // common_number_parse
#include <stdio.h>         // fprintf
#include <string.h>        // strrchr
#include <unistd.h>        // access

#define AT(member) offsetof(camsim_options_t, member)

/// Parse two rising heights; a later check compares them with the part.
static bool take_window(void *options, const char *text, common_error_t *e)
{
    sim_cut_options_t *cut = &((camsim_options_t *)options)->cut;
    char first[40];
    const char *colon = strchr(text, ':');
    const bool is_split = colon != NULL && (size_t)(colon - text) < sizeof first;
    if (is_split) {
        memcpy(first, text, (size_t)(colon - text));
        first[colon - text] = '\0';
        cut->has_window = common_number_parse(first, &cut->window_first_mm) &&
                          common_number_parse(colon + 1, &cut->window_last_mm) &&
                          cut->window_first_mm < cut->window_last_mm;
    }
    return cut->has_window ||
           common_error(e, "--scallop-mm %.60s: no two rising heights; give FROM:TO in mm", text);
}

/// Parse rising heights of sections; a later check compares them with the part.
static bool take_heights(void *options, const char *text, common_error_t *e)
{
    sim_cut_options_t *cut = &((camsim_options_t *)options)->cut;
    const char *rest = text;
    cut->n_sections = 0;
    while (rest != NULL && cut->n_sections < sim_sections_most) {
        char word[40];
        const char *comma = strchr(rest, ',');
        const size_t length = comma != NULL ? (size_t)(comma - rest) : strlen(rest);
        const int n = cut->n_sections;
        if (length >= sizeof word) {
            break;
        }
        memcpy(word, rest, length);
        word[length] = '\0';
        if (!common_number_parse(word, &cut->section_mm[n]) ||
            (n > 0 && cut->section_mm[n] <= cut->section_mm[n - 1])) {
            break;
        }
        cut->n_sections++;
        rest = comma != NULL ? comma + 1 : NULL;
    }
    return rest == NULL ||
           common_error(e, "--sections-mm %.60s: no rising heights; give 1 .. %d in mm: A,B,C",
                        text, sim_sections_most);
}

static bool take_set(void *options, const char *text, common_error_t *e)
{
    camsim_options_t *o = options;
    char name[80];
    double value;
    const char *equals = strchr(text, '=');
    if (equals == NULL || (size_t)(equals - text) >= sizeof name ||
        !common_number_parse(equals + 1, &value)) {
        return common_error(e, "--set %.80s: give PARAM=VALUE with a whole number; see cam_param.h",
                            text);
    }
    memcpy(name, text, (size_t)(equals - text));
    name[equals - text] = '\0';
    return sim_wishes_add(&o->cut.wishes, name, value, "--set", e);
}

static bool take_inject(void *options, const char *text, common_error_t *e)
{
    camsim_options_t *o = options;
    sim_session_options_t *session = &o->cut.session;
    if (session->n_injects == sim_session_max_injects) {
        return common_error(e, "--inject %.60s: one too many; give at most %d", text,
                            sim_session_max_injects);
    }
    const sim_inject_place_t place = strcmp(o->command, "bus") == 0    ? sim_inject_on_bus
                                     : strcmp(o->command, "live") == 0 ? sim_inject_in_live
                                                                       : sim_inject_in_run;
    return sim_inject_parse(&session->inject[session->n_injects++], text, place, e);
}

static const camsim_option_t options[] = {
    CAMSIM_NUMBER("rpm", "N", AT(cut.rpm), 0.001, 60000.0, "r/min",
                  "spindle speed, r/min (default: the table's)"),
    CAMSIM_NUMBER("feed", "MM", AT(cut.feed_mm), 0.000001, 10.0, "mm per turn",
                  "feed per turn (default: the table's)"),
    CAMSIM_TEXT("machine", "M.toml", AT(machine_path),
                "machine file (default: built in, see host_sim/machines/default.toml)"),
    CAMSIM_TAKEN("set", "PARAM=VALUE", take_set,
                 "a parameter of the firmware, by its name in cam_param.h; repeatable"),
    CAMSIM_TEXT("design", "F.json", AT(cut.session.design_path),
                "exact geometry for the gauge (default: NAME.json next to TABLE)"),
    CAMSIM_NUMBER("tolerance-um", "T", AT(cut.session.tolerance_um), 0.0, 1e6, "um",
                  "largest form error accepted (default: 5)"),
    CAMSIM_TEXT("trace", "F.csv", AT(out_path[sim_table_trace]),
                "every tick: inputs, set-points, outputs, truth"),
    CAMSIM_NUMBER("trace-every", "N", AT(cut.trace_every), 1.0, 1e9, "ticks",
                  "only one tick of N in the trace"),
    CAMSIM_TEXT("surface", "F.csv", AT(out_path[sim_table_surface]),
                "turn,z_mm,radius_mm,error_nm of the worst sample of each cell, and control_nm "
                "where the table plays a refit or a filter"),
    CAMSIM_TEXT("summary", "F.json", AT(out_path[camsim_summary]), "results"),
    CAMSIM_TEXT("removal", "F.csv", AT(out_path[sim_table_removal]),
                "metal removed, power and forces of every time slice"),
    CAMSIM_NUMBER("slice-us", "T", AT(slice_us), 1.0, 1e9, "microseconds",
                  "length of those slices (default: a 120th of the mean turn)"),
    CAMSIM_NUMBER("kc-n-mm2", "K", AT(cut.kc_n_mm2), 0.001, 1e6, "N/mm2",
                  "specific cutting force (default: 700)"),
    CAMSIM_NUMBER("kc-exponent", "M", AT(cut.kc_exponent), 0.0, 0.9, "a pure number",
                  "its size effect: K h^-M at a chip h mm thick, then K is kc1.1; a nose "
                  "(--nose-mm) cuts thinner chips (default: 0, none)"),
    CAMSIM_NUMBER("nose-mm", "R", AT(cut.nose_mm), 0.01, 100.0, "mm",
                  "radius of the tool's nose, for the gauge (default: that of the machine file, "
                  "else of the part file); also makes the surface between tracks"),
    CAMSIM_TEXT("scallop", "F.csv", AT(out_path[sim_table_scallop]),
                "turn,z_mm,proud_um of that surface; with --nose-mm"),
    CAMSIM_TAKEN("scallop-mm", "FROM:TO", take_window,
                 "its heights (default: four feeds in the middle)"),
    CAMSIM_TEXT("sections", "F.csv", AT(out_path[sim_table_sections]),
                "section,turn,z_mm,radius_mm,deviation_nm at 3600 angles of each section, and of "
                "lines along the height at 0, 90, 180, 270 degrees (section 0)"),
    CAMSIM_TAKEN("sections-mm", "A,B,..", take_heights,
                 "their heights, at most 16 (default: five, or in the middle of lobes)"),
    CAMSIM_NUMBER("tool-tip-mm", "R", AT(cut.tip_mm), 0.05, 1000.0, "mm",
                  "radius of the tip that turns a cam (default: 0.4)"),
    CAMSIM_SWITCH("no-feed-forward", AT(cut.is_without_feed_forward), "k1 = k2 = 0"),
    CAMSIM_SWITCH("no-lead", AT(cut.is_without_lead), "no dead-time compensation"),
    CAMSIM_SWITCH("no-learning", AT(cut.is_without_learning),
                  "no learning by default: no rehearsal, short feed ramps"),
    CAMSIM_WHOLE("seed", "N", AT(seed), 0.0, 9007199254740992.0,
                 "seed of the encoder's noise (default: 1)"),
    CAMSIM_NUMBER("turns-limit", "N", AT(cut.max_turns), 0.001, 1e9, "turns",
                  "operator's stop after N turns of cutting"),
    CAMSIM_NUMBER("max-seconds", "S", AT(cut.session.max_s), 0.001, 1e7, "seconds",
                  "give up after S of machine time (default: twice the plan and a minute)"),
    CAMSIM_SWITCH("progress", AT(is_progress_shown), "show progress on standard error"),
    CAMSIM_TAKEN("inject", "KIND@SECONDS[:VALUE]", take_inject,
                 "a fault or what an operator does; below"),
    CAMSIM_SWITCH("help", AT(is_help), "show this help"),
};

static const char help[] =
    "A whole cut in virtual time.\v"
    "--inject is repeatable; seconds of cutting, or KIND@tSECONDS since the start:\n"
    "  estop  drive  bus  lost-counts:N  encoder-jump:N  encoder-stuck\n"
    "  encoder-rate:PERCENT  encoder-dither:N\n"
    "  index-dead  late-tick:PERCENT  reverse  spindle-speed:RPM  spindle-stop\n"
    "  z-offset:MM  u-block  u-scale-stuck  u-reversed  u-push:N  u-limit:-1|0|1\n"
    "  swing-block  table-flip:BYTE  stop\n"
    "  clock-drift:PPM  tick-jitter:PERCENT  tick-burst:PERCENT  tick-twice:PERCENT\n"
    "  hold  resume  feed-override:PERCENT  spindle-override:PERCENT  trim:UM,\n"
    "  as an operator\n"
    "\n"
    "Exit status: 0 done, 1 fault, time-out, out of tolerance or not gauged, 2 wrong usage or bad "
    "input.";

void camsim_options_help(void)
{
    const camsim_set_t set = {options, sizeof options / sizeof options[0], NULL};
    camsim_help("camsim run", "TABLE", help, set);
}

/// Find NAME.json next to NAME.camtab.
static bool find_design(camsim_options_t *o, common_error_t *e)
{
    const char *name = strrchr(o->table_path, '/');
    const char *dot = strrchr(name != NULL ? name : o->table_path, '.');
    const size_t stem = dot != NULL ? (size_t)(dot - o->table_path) : strlen(o->table_path);
    if (stem + sizeof ".json" > sizeof o->design_path) {
        return common_error(e, "%.60s...: path too long; use a shorter one", o->table_path);
    }
    memcpy(o->design_path, o->table_path, stem);
    memcpy(o->design_path + stem, ".json", sizeof ".json");
    if (access(o->design_path, F_OK) == 0) {
        o->cut.session.design_path = o->design_path;
    }
    return true;
}

static bool check_outputs(const camsim_options_t *o, common_error_t *e)
{
    enum { n_inputs = 3, n_paths = n_inputs + camsim_n_outs };
    const char *path[n_paths] = {o->table_path, o->machine_path, o->cut.session.design_path};
    memcpy(path + n_inputs, o->out_path, sizeof o->out_path);
    for (int i = n_inputs; i < n_paths; i++) {
        for (int k = 0; k < i; k++) {
            if (path[i] != NULL && path[k] != NULL && strcmp(path[i], path[k]) == 0) {
                return common_error(e, "%s: named for two purposes; give every output its own path",
                                    path[i]);
            }
        }
    }
    return true;
}

const char *const camsim_out_option[camsim_n_outs] = {
    [sim_table_trace] = "--trace",       [sim_table_surface] = "--surface",
    [sim_table_removal] = "--removal",   [sim_table_scallop] = "--scallop",
    [sim_table_sections] = "--sections", [camsim_summary] = "--summary",
};

bool camsim_open_cut(const camsim_options_t *o, sim_cut_t *cut, common_error_t *e)
{
    sim_file_t file;
    if (!sim_file_read(&file, o->table_path, camsim_max_table_bytes, e)) {
        return false;
    }
    const bool is_open = sim_cut_open(cut, &o->cut, file.bytes, file.size, o->table_path, e);
    sim_file_free(&file);
    return is_open;
}

void camsim_warn_of_retired(const camsim_options_t *o)
{
    const common_error_t *option = &o->cut.wishes.retired;
    const common_error_t *file = &o->cut.session.config.controller.retired;
    const common_error_t *first = option->text[0] != '\0' ? option : file;
    if (first->text[0] != '\0') {
        (void)fprintf(stderr, "camsim: %s\n", first->text);
    }
}

void camsim_warn_of_design(const camsim_options_t *o)
{
    if (o->cut.session.design_path == NULL) {
        (void)fprintf(stderr,
                      "camsim: warning: %s: missing, so the gauge compares with the table itself\n",
                      o->design_path);
    }
}

/// Check what the options say together.
static bool check(camsim_options_t *o, common_error_t *e)
{
    o->cut.session.has_map = o->out_path[sim_table_surface] != NULL;
    if (o->machine_path != NULL && !sim_config_load(&o->cut.session.config, o->machine_path, e)) {
        return false;
    }
    if (o->cut.session.design_path == NULL && !find_design(o, e)) {
        return false;
    }
    if ((o->out_path[sim_table_scallop] != NULL || o->cut.has_window) && o->cut.nose_mm <= 0.0) {
        return common_error(e, "--scallop, --scallop-mm: no tool for it; give --nose-mm, too");
    }
    o->cut.has_sections = o->out_path[sim_table_sections] != NULL;
    if (o->cut.n_sections > 0 && !o->cut.has_sections) {
        return common_error(e, "--sections-mm: no file for them; give --sections F.csv, too");
    }
    return check_outputs(o, e);
}

bool camsim_options_read_with(camsim_options_t *o, camsim_set_t own, int argc, char **argv,
                              common_error_t *e)
{
    memset(o, 0, sizeof *o);
    o->command = argv[0];
    o->cut.session.tolerance_um = 5.0;
    o->cut.kc_n_mm2 = 700.0;
    o->cut.session.config = sim_config_defaults();
    o->seed = 1.0;
    const camsim_set_t sets[] = {own, {options, sizeof options / sizeof options[0], o}};
    camsim_rest_t rest = {.n_arguments = 0};
    if (!camsim_parse(sets, sizeof sets / sizeof sets[0], argc, argv, &o->is_help, &rest, e)) {
        return false;
    }
    if (o->is_help) {
        return true;
    }
    if (rest.n_arguments != 1) {
        return common_error(e, "%s: give one TABLE, not %d; see camsim %s --help", o->command,
                            rest.n_arguments, o->command);
    }
    o->table_path = rest.argument;
    o->cut.slice_s = o->slice_us * 1e-6;
    o->cut.session.nose_mm = o->cut.nose_mm;
    o->cut.session.seed = (uint64_t)o->seed;
    return check(o, e);
}

bool camsim_options_read(camsim_options_t *o, int argc, char **argv, common_error_t *e)
{
    return camsim_options_read_with(o, (camsim_set_t){.n = 0}, argc, argv, e);
}
