// SPDX-License-Identifier: Apache-2.0
#define _POSIX_C_SOURCE 200809L // NOLINT(bugprone-reserved-identifier): open_memstream, strdup
#include "sim_api.h"
#include "camsim.h"          // camsim_options_read
#include "sim_cut_summary.h" // sim_cut_summary
#include "sim_map.h"         // sim_map_surface
#include "hal/version.h"     // CAMTURN_VERSION
#include "sim_trace.h"       // sim_trace_drain
#include <stdlib.h>          // calloc, free
#include <string.h>          // memset, strdup

enum { max_words = 400 };

struct sim_api {
    char *word[max_words + 2]; ///< of the command line, copied: the options point to them
    int n_words;
    camsim_options_t options;
    sim_cut_t cut;
    bool is_open; ///< the cut is to be closed
    sim_out_t trace, out;
    sim_values_t trace_values, surface_values;
    char *summary;
    common_error_t error;
};

/// The session whose cut firmware and port work for.
static sim_api_t *at_work;

sim_api_t *sim_api_open(void)
{
    return calloc(1, sizeof(sim_api_t));
}

void sim_api_end(sim_api_t *s)
{
    if (s->is_open) {
        sim_cut_close(&s->cut);
    }
    s->is_open = false;
    at_work = at_work == s ? NULL : at_work;
    sim_values_free(&s->trace_values);
    sim_values_free(&s->surface_values);
    free(s->summary);
    s->summary = NULL;
    for (int i = 0; i < s->n_words; i++) {
        free(s->word[i]);
        s->word[i] = NULL;
    }
    s->n_words = 0;
}

void sim_api_close(sim_api_t *s)
{
    if (s != NULL) {
        sim_api_end(s);
        free(s);
    }
}

const char *sim_api_version(void)
{
    return CAMTURN_VERSION;
}

const char *sim_api_error(const sim_api_t *s)
{
    return s->error.text;
}

static bool add_word(sim_api_t *s, const char *word)
{
    s->word[s->n_words] = strdup(word);
    return s->word[s->n_words++] != NULL || common_error(&s->error, "not enough memory; free some");
}

static bool copy_words(sim_api_t *s, const char *const *words, int n_words)
{
    if (n_words < 0 || n_words > max_words) {
        return common_error(&s->error, "%d words; give at most %d", n_words, max_words);
    }
    bool is_good = add_word(s, "run");
    for (int i = 0; i < n_words && is_good; i++) {
        is_good = add_word(s, words[i]);
    }
    return is_good;
}

/// Refuse what only a program has: help and files.
static bool check_options(sim_api_t *s)
{
    const camsim_options_t *o = &s->options;
    for (int i = 0; i < camsim_n_outs; i++) {
        if (o->out_path[i] != NULL) {
            return common_error(&s->error, "%s: results come back in memory; leave the option out",
                                o->out_path[i]);
        }
    }
    return !o->is_help ||
           common_error(&s->error, "--help: camsim run --help tells the options; leave it out");
}

static bool read_machine(sim_api_t *s, const char *machine, size_t size, const char *name)
{
    if (machine == NULL) {
        return true;
    }
    if (s->options.machine_path != NULL) {
        return common_error(&s->error, "--machine %s: there is a machine's text, too; give one",
                            s->options.machine_path);
    }
    return sim_config_read(&s->options.cut.session.config, machine, size, name, &s->error);
}

static bool open_cut(sim_api_t *s)
{
    sim_file_t file;
    const char *path = s->options.table_path;
    if (!sim_file_read(&file, path, camsim_max_table_bytes, &s->error)) {
        return false;
    }
    memset(&s->cut, 0, sizeof s->cut);
    s->is_open = sim_cut_open(&s->cut, &s->options.cut, file.bytes, file.size, path, &s->error);
    sim_file_free(&file);
    return s->is_open && camsim_check_lobes(&s->options, &s->cut, &s->error);
}

static void begin_trace(sim_api_t *s, bool is_traced)
{
    (void)sim_out_open(&s->trace, NULL, "", &s->error); // not wanted
    if (is_traced) {
        sim_out_open_values(&s->trace, "trace", &s->trace_values);
        sim_trace_header(&s->trace, &s->cut);
    }
}

bool sim_api_begin(sim_api_t *s, const char *const *words, int n_words, const char *machine,
                   size_t machine_size, const char *name, bool is_traced)
{
    sim_api_end(s);
    if (at_work != NULL) {
        return common_error(&s->error, "another cut is open in this process; end it first");
    }
    at_work = s;
    if (!copy_words(s, words, n_words) ||
        !camsim_options_read(&s->options, s->n_words, s->word, &s->error) || !check_options(s) ||
        !read_machine(s, machine, machine_size, name)) {
        at_work = NULL;
        return false;
    }
    s->options.cut.is_traced = is_traced;
    s->options.cut.session.has_map = true;
    if (!open_cut(s)) {
        sim_api_end(s);
        return false;
    }
    begin_trace(s, is_traced);
    return true;
}

bool sim_api_run(sim_api_t *s, uint64_t n_ticks)
{
    sim_cut_t *cut = &s->cut;
    for (uint64_t i = 0; i < n_ticks && s->is_open && cut->end == sim_cut_running; i++) {
        sim_cut_tick(cut);
        if (s->trace.name != NULL) {
            sim_trace_drain(&s->trace, cut);
        }
    }
    return s->is_open && cut->end == sim_cut_running;
}

double sim_api_progress(const sim_api_t *s)
{
    const double turns = s->is_open ? sim_cut_planned_turns(&s->cut) : 0.0;
    const double share = turns > 0.0 ? s->cut.session.cut_turns / turns : 0.0;
    return share < 1.0 ? share : 1.0;
}

/// @return whether the summary was made
static bool make_summary(sim_api_t *s, double wall_s)
{
    size_t size;
    free(s->summary);
    s->summary = NULL;
    FILE *stream = open_memstream(&s->summary, &size);
    if (stream == NULL) {
        return false;
    }
    sim_out_open_stream(&s->out, "summary", stream);
    const bool is_made = sim_cut_summary(&s->out, &s->cut, s->options.table_path, wall_s);
    return sim_out_finish(&s->out, &s->error) && is_made;
}

static void make_surface(sim_api_t *s)
{
    sim_values_free(&s->surface_values);
    sim_out_open_values(&s->out, "surface", &s->surface_values);
    sim_map_surface(&s->out, &s->cut.session);
}

int sim_api_finish(sim_api_t *s, double wall_s)
{
    if (!s->is_open) {
        (void)common_error(&s->error, "no cut is open; begin one");
        return camsim_wrong;
    }
    make_surface(s);
    if (!make_summary(s, wall_s) || s->surface_values.is_lost || s->trace_values.is_lost) {
        (void)common_error(&s->error,
                           "not enough memory for the results; free some, or trace less");
        return camsim_wrong;
    }
    s->error.text[0] = '\0';
    return camsim_judge_cut(&s->cut, s->options.table_path, &s->error);
}

static const double *values_of(const sim_values_t *v, size_t *n)
{
    *n = v->n;
    return v->value;
}

const double *sim_api_surface(const sim_api_t *s, size_t *n)
{
    return values_of(&s->surface_values, n);
}

const double *sim_api_trace(const sim_api_t *s, size_t *n)
{
    return values_of(&s->trace_values, n);
}

const char *sim_api_surface_header(const sim_api_t *s)
{
    return s->surface_values.header;
}

const char *sim_api_trace_header(const sim_api_t *s)
{
    return s->trace_values.header;
}

const char *sim_api_summary(const sim_api_t *s)
{
    return s->summary != NULL ? s->summary : "";
}
