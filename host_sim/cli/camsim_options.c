// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE // NOLINT(bugprone-reserved-identifier): getopt_long
#include "camsim.h"
#include "common_number.h" // common_number_parse
#include "sim_target.h"    // sim_target_find
#include <getopt.h>        // getopt_long
#include <stdio.h>         // fprintf
#include <string.h>        // strrchr
#include <unistd.h>        // access

enum {
    opt_rpm = 256,
    opt_feed,
    opt_machine,
    opt_set,
    opt_design,
    opt_tolerance,
    opt_trace,
    opt_every,
    opt_surface,
    opt_summary,
    opt_removal,
    opt_slice,
    opt_kc,
    opt_kc_exponent,
    opt_nose,
    opt_scallop,
    opt_window,
    opt_sections,
    opt_heights,
    opt_tip,
    opt_no_feed_forward,
    opt_no_lead,
    opt_seed,
    opt_turns,
    opt_max_seconds,
    opt_progress,
    opt_target,
    opt_target_image,
    opt_inject,
    opt_help,
};

static const struct option options[] = {
    {"rpm", required_argument, NULL, opt_rpm},
    {"feed", required_argument, NULL, opt_feed},
    {"machine", required_argument, NULL, opt_machine},
    {"set", required_argument, NULL, opt_set},
    {"design", required_argument, NULL, opt_design},
    {"tolerance-um", required_argument, NULL, opt_tolerance},
    {"trace", required_argument, NULL, opt_trace},
    {"trace-every", required_argument, NULL, opt_every},
    {"surface", required_argument, NULL, opt_surface},
    {"summary", required_argument, NULL, opt_summary},
    {"removal", required_argument, NULL, opt_removal},
    {"slice-us", required_argument, NULL, opt_slice},
    {"kc-n-mm2", required_argument, NULL, opt_kc},
    {"kc-exponent", required_argument, NULL, opt_kc_exponent},
    {"nose-mm", required_argument, NULL, opt_nose},
    {"scallop", required_argument, NULL, opt_scallop},
    {"scallop-mm", required_argument, NULL, opt_window},
    {"sections", required_argument, NULL, opt_sections},
    {"sections-mm", required_argument, NULL, opt_heights},
    {"tool-tip-mm", required_argument, NULL, opt_tip},
    {"no-feed-forward", no_argument, NULL, opt_no_feed_forward},
    {"no-lead", no_argument, NULL, opt_no_lead},
    {"seed", required_argument, NULL, opt_seed},
    {"turns-limit", required_argument, NULL, opt_turns},
    {"max-seconds", required_argument, NULL, opt_max_seconds},
    {"progress", no_argument, NULL, opt_progress},
    {"target", required_argument, NULL, opt_target},
    {"target-image", required_argument, NULL, opt_target_image},
    {"inject", required_argument, NULL, opt_inject},
    {"help", no_argument, NULL, opt_help},
    {NULL, 0, NULL, 0},
};

/// Parse a number of an option, within its range, ends included.
static bool take_number(double *value, const char *option, const char *text, double min, double max,
                        const char *unit, common_error_t *e)
{
    if (!common_number_parse(text, value)) {
        return common_error(e, "--%s %.60s: not a finite number; give %s, %.12g .. %.12g", option,
                            text, unit, min, max);
    }
    if (*value < min || *value > max) {
        return common_error(e, "--%s %.60s: out of range; give %s, %.12g .. %.12g", option, text,
                            unit, min, max);
    }
    return true;
}

/// Parse two rising heights; a later check compares them with the part.
static bool take_window(sim_cut_options_t *cut, const char *text, common_error_t *e)
{
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
static bool take_heights(sim_cut_options_t *cut, const char *text, common_error_t *e)
{
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

static bool take_set(camsim_options_t *o, const char *text, common_error_t *e)
{
    char name[80];
    double value;
    const char *equals = strchr(text, '=');
    if (equals == NULL || (size_t)(equals - text) >= sizeof name ||
        !common_number_parse(equals + 1, &value)) {
        return common_error(
            e, "--set %.80s: wants PARAM=VALUE with a whole number; see cam_param.h", text);
    }
    memcpy(name, text, (size_t)(equals - text));
    name[equals - text] = '\0';
    return sim_wishes_add(&o->cut.wishes, name, value, "--set", e);
}

static bool take_inject(camsim_options_t *o, const char *text, common_error_t *e)
{
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

static bool take_switch(camsim_options_t *o, int option)
{
    switch (option) {
    case opt_no_feed_forward:
        o->cut.is_without_feed_forward = true;
        return true;
    case opt_no_lead:
        o->cut.is_without_lead = true;
        return true;
    case opt_progress:
        o->is_progress_shown = true;
        return true;
    case opt_help:
        o->is_help = true;
        return true;
    default:
        return false;
    }
}

static const char **path_of(camsim_options_t *o, int option)
{
    switch (option) {
    case opt_machine:
        return &o->machine_path;
    case opt_trace:
        return &o->out_path[camsim_trace];
    case opt_surface:
        return &o->out_path[camsim_surface];
    case opt_summary:
        return &o->out_path[camsim_summary];
    case opt_removal:
        return &o->out_path[camsim_removal];
    case opt_scallop:
        return &o->out_path[camsim_scallop];
    case opt_sections:
        return &o->out_path[camsim_sections];
    case opt_design:
        return &o->cut.session.design_path;
    case opt_target:
        return &o->cut.target;
    case opt_target_image:
        return &o->cut.target_image;
    default:
        return NULL;
    }
}

static bool take_value(camsim_options_t *o, int option, const char *text, common_error_t *e)
{
    sim_cut_options_t *cut = &o->cut;
    sim_session_options_t *session = &cut->session;
    double value;
    switch (option) {
    case opt_rpm:
        return take_number(&cut->rpm, "rpm", text, 0.001, 60000.0, "r/min", e);
    case opt_feed:
        return take_number(&cut->feed_mm, "feed", text, 0.000001, 10.0, "mm per turn", e);
    case opt_tolerance:
        return take_number(&session->tolerance_um, "tolerance-um", text, 0.0, 1e6, "um", e);
    case opt_every:
        return take_number(&cut->trace_every, "trace-every", text, 1.0, 1e9, "ticks", e);
    case opt_turns:
        return take_number(&cut->max_turns, "turns-limit", text, 0.001, 1e9, "turns", e);
    case opt_slice:
        if (!take_number(&value, "slice-us", text, 1.0, 1e9, "microseconds", e)) {
            return false;
        }
        cut->slice_s = value * 1e-6;
        return true;
    case opt_kc:
        return take_number(&cut->kc_n_mm2, "kc-n-mm2", text, 0.001, 1e6, "N/mm2", e);
    case opt_kc_exponent:
        return take_number(&cut->kc_exponent, "kc-exponent", text, 0.0, 0.9, "a pure number", e);
    case opt_nose:
        if (!take_number(&cut->nose_mm, "nose-mm", text, 0.01, 100.0, "mm", e)) {
            return false;
        }
        session->nose_mm = cut->nose_mm;
        return true;
    case opt_window:
        return take_window(cut, text, e);
    case opt_heights:
        return take_heights(cut, text, e);
    case opt_tip:
        return take_number(&cut->tip_mm, "tool-tip-mm", text, 0.05, 1000.0, "mm", e);
    case opt_max_seconds:
        return take_number(&session->max_s, "max-seconds", text, 0.001, 1e7, "seconds", e);
    case opt_seed:
        if (!take_number(&value, "seed", text, 0.0, 9007199254740992.0, "a whole number", e)) {
            return false;
        }
        session->seed = (uint64_t)value;
        return (double)session->seed == value ||
               common_error(e, "--seed %.60s: not whole; give a whole number 0 .. 9007199254740992",
                            text);
    case opt_set:
        return take_set(o, text, e);
    default: // opt_inject
        return take_inject(o, text, e);
    }
}

static bool take_option(camsim_options_t *o, int option, char **argv, common_error_t *e)
{
    if (option == '?' || option == ':') {
        return common_error(e, "%s: %.60s: unknown option or value missing; see camsim %s --help",
                            o->command, argv[optind - 1], o->command);
    }
    if (take_switch(o, option)) {
        return true;
    }
    const char **path = path_of(o, option);
    if (path == NULL) {
        return take_value(o, option, optarg, e);
    }
    *path = optarg;
    return optarg[0] != '\0' || common_error(e, "%s: %.60s: an empty path; give a file name",
                                             o->command, argv[optind - 1]);
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

/// Check the target and find its image: the user's, or the one built along with this program.
static bool find_target(camsim_options_t *o, common_error_t *e)
{
    if (o->cut.target == NULL) {
        return o->cut.target_image == NULL ||
               common_error(e, "--target-image %.60s: no target for it; give --target",
                            o->cut.target_image);
    }
    const sim_target_t *target = sim_target_find(o->cut.target, e);
    if (target == NULL || o->cut.target_image != NULL) {
        return target != NULL;
    }
    o->cut.target_image = o->target_image;
    return sim_target_image(target, o->target_image, sizeof o->target_image, e);
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

bool camsim_open_outs(sim_out_t *outs, const camsim_options_t *o, int n, common_error_t *e)
{
    static const char *const option[camsim_n_outs] = {"--trace",   "--surface", "--summary",
                                                      "--removal", "--scallop", "--sections"};
    return sim_out_open_all(outs, o->out_path, option, n, e);
}

void camsim_warn_of_design(const camsim_options_t *o)
{
    if (o->cut.session.design_path == NULL) {
        (void)fprintf(stderr,
                      "camsim: warning: %s: missing, so the gauge compares with the table itself\n",
                      o->design_path);
    }
}

bool camsim_options_read(camsim_options_t *o, int argc, char **argv, common_error_t *e)
{
    memset(o, 0, sizeof *o);
    o->command = argv[0];
    o->cut.session.tolerance_um = 5.0;
    o->cut.kc_n_mm2 = 700.0;
    o->cut.session.config = sim_config_defaults();
    o->cut.session.seed = 1;
    opterr = 0;
    optind = 0; // restart: this process may have parsed options before
    int option;
    while ((option = getopt_long(argc, argv, ":", options, NULL)) != -1) {
        if (!take_option(o, option, argv, e)) {
            return false;
        }
        if (o->is_help) {
            return true;
        }
    }
    if (optind + 1 != argc) {
        return common_error(e, "%s: wants one TABLE, got %d; see camsim %s --help", o->command,
                            argc - optind, o->command);
    }
    o->table_path = argv[optind];
    o->cut.is_traced = o->out_path[camsim_trace] != NULL;
    if (o->machine_path != NULL && !sim_config_load(&o->cut.session.config, o->machine_path, e)) {
        return false;
    }
    if (!find_target(o, e) || (o->cut.session.design_path == NULL && !find_design(o, e))) {
        return false;
    }
    if ((o->out_path[camsim_scallop] != NULL || o->cut.has_window) && o->cut.nose_mm <= 0.0) {
        return common_error(e, "--scallop, --scallop-mm: no tool for it; give --nose-mm, too");
    }
    o->cut.has_sections = o->out_path[camsim_sections] != NULL;
    if (o->cut.n_sections > 0 && !o->cut.has_sections) {
        return common_error(e, "--sections-mm: no file for them; give --sections F.csv, too");
    }
    return check_outputs(o, e);
}
