// SPDX-License-Identifier: Apache-2.0
#define _POSIX_C_SOURCE 200809L // NOLINT(bugprone-reserved-identifier): strdup
#include "sim_api.h"
#include "camsim.h"          // camsim_options_read
#include "sim_config.h"      // sim_config_keys
#include "sim_cut_pass.h"    // sim_cut_planned_s
#include "sim_cut_summary.h" // sim_cut_summary
#include "hal/version.h"     // CAMTURN_VERSION
#include <stdlib.h>          // calloc, free
#include <string.h>          // memset, strdup

enum { max_words = 400 };

struct sim_api {
    char *word[max_words + 2]; ///< of the command line, copied: the options point to them
    int n_words;
    camsim_options_t options;
    sim_cut_t cut;
    bool is_open; ///< the cut is to be closed
    sim_tables_t tables;
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
    sim_tables_free(&s->tables);
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

const char *sim_api_machine_keys(void)
{
    return sim_config_keys();
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
    memset(&s->cut, 0, sizeof s->cut);
    s->is_open = camsim_open_cut(&s->options, &s->cut, &s->error);
    return s->is_open && camsim_check_lobes(&s->options, &s->cut, &s->error);
}

bool sim_api_begin(sim_api_t *s, const char *const *words, int n_words, const char *machine,
                   size_t machine_size, const char *name)
{
    sim_api_end(s);
    if (at_work != NULL) {
        return common_error(&s->error, "another cut is open in this process; end it first");
    }
    at_work = s;
    if (!copy_words(s, words, n_words) ||
        !camsim_options_read(&s->options, s->n_words, s->word, &s->error) ||
        (s->options.is_help &&
         !common_error(&s->error, "--help: camsim run --help lists the options; leave it out")) ||
        !read_machine(s, machine, machine_size, name) || !open_cut(s)) {
        sim_api_end(s);
        return false;
    }
    sim_tables_open(&s->tables, &s->cut, s->options.out_path);
    return true;
}

void sim_api_plan(const sim_api_t *s, double *turns, double *seconds, double *tick_hz)
{
    *turns = sim_cut_planned_in_all(&s->cut);
    *seconds = sim_cut_planned_s(&s->cut);
    *tick_hz = s->options.cut.session.config.lathe.tick_hz;
}

bool sim_api_run(sim_api_t *s, uint64_t n_ticks)
{
    sim_cut_t *cut = &s->cut;
    for (uint64_t i = 0; i < n_ticks && s->is_open && cut->end == sim_cut_running; i++) {
        sim_cut_tick(cut);
        sim_tables_tick(&s->tables, cut);
    }
    return s->is_open && cut->end == sim_cut_running;
}

double sim_api_progress(const sim_api_t *s)
{
    const double share = s->is_open ? s->cut.port.time_s / sim_cut_planned_s(&s->cut) : 0.0;
    return share < 1.0 ? share : 1.0;
}

int sim_api_finish(sim_api_t *s, double wall_s)
{
    if (!s->is_open) {
        (void)common_error(&s->error, "no cut is open; begin one");
        return camsim_wrong;
    }
    sim_tables_end(&s->tables, &s->cut);
    free(s->summary);
    s->summary = sim_cut_summary(&s->cut, s->options.table_path, wall_s);
    bool is_lost = s->summary == NULL;
    for (int i = 0; i < sim_n_tables; i++) {
        is_lost = is_lost || s->tables.rows[i].is_lost;
    }
    if (is_lost) {
        (void)common_error(&s->error,
                           "not enough memory for the results; free some, or trace less");
        free(s->summary);
        s->summary = NULL;
        return camsim_wrong;
    }
    s->error.text[0] = '\0';
    return camsim_judge_cut(&s->cut, s->options.table_path, &s->error);
}

/// @return index of the output whose option has this name; camsim_n_outs for any other name
static int output_of(const char *name)
{
    int i = 0;
    while (i < camsim_n_outs && strcmp(name, camsim_out_option[i] + strlen("--")) != 0) {
        i++;
    }
    return i;
}

const char *sim_api_path(const sim_api_t *s, const char *output)
{
    const int i = output_of(output);
    return i < camsim_n_outs ? s->options.out_path[i] : NULL;
}

const char *sim_api_columns(const sim_api_t *s, const char *table)
{
    const int i = output_of(table);
    return i < sim_n_tables ? s->tables.rows[i].columns : NULL;
}

const int64_t *sim_api_rows(const sim_api_t *s, const char *table, size_t *n)
{
    const int i = output_of(table);
    *n = i < sim_n_tables ? s->tables.rows[i].n : 0u;
    return i < sim_n_tables ? s->tables.rows[i].number : NULL;
}

void sim_api_drop(sim_api_t *s, const char *table)
{
    const int i = output_of(table);
    if (i < sim_n_tables) {
        sim_rows_drop(&s->tables.rows[i]);
    }
}

const char *sim_api_summary(const sim_api_t *s)
{
    return s->summary != NULL ? s->summary : "";
}
