// SPDX-License-Identifier: Apache-2.0
#include "camsim_parse.h"
#include "common_number.h" // common_number_parse
#include <argp.h>          // argp_parse, argp_help
#include <errno.h>         // EINVAL
#include <stdio.h>         // stdout
#include <string.h>        // strcmp

enum { first_key = 256, most_options = 64 };

typedef struct {
    const camsim_option_t *option[most_options];
    void *into[most_options];
    int n;
    struct argp_option table[most_options + 1];
    const bool *is_help;
    camsim_rest_t *rest;
    common_error_t *e;
} parse_t;

static bool take_number(const camsim_option_t *o, double *value, const char *text,
                        common_error_t *e)
{
    double v = 0.0;
    const char *why = !common_number_parse(text, &v)             ? "not a finite number"
                      : v < o->min || v > o->max                 ? "out of range"
                      : o->is_whole && v != (double)(long long)v ? "not whole"
                                                                 : NULL;
    if (why != NULL) {
        return common_error(e, "--%s %.60s: %s; give %s, %.16g .. %.16g", o->name, text, why,
                            o->unit, o->min, o->max);
    }
    *value = v;
    return true;
}

static bool take_option(const camsim_option_t *o, void *into, const char *text, common_error_t *e)
{
    void *at = (char *)into + o->at;
    if (o->take != NULL) {
        return o->take(into, text, e);
    }
    if (o->unit != NULL) {
        return take_number(o, at, text, e);
    }
    if (o->argument == NULL) {
        *(bool *)at = true;
        return true;
    }
    *(const char **)at = text;
    return text[0] != '\0' || common_error(e, "--%s: empty; give %s", o->name, o->argument);
}

/// Name the word that argp does not take.
static void refuse(const parse_t *p, const struct argp_state *state)
{
    const int last = state->next - 1; // short options are none of ours, so getopt stays before them
    const char *word = state->argv[state->argv[last][0] == '-' ? last : state->next];
    const char *why = "unknown option";
    for (int i = 0; i < p->n; i++) {
        if (strncmp(word, "--", 2) == 0 && strcmp(word + 2, p->option[i]->name) == 0) {
            why = "value missing";
        }
    }
    (void)common_error(p->e, "%s: %.60s: %s; see camsim %s --help", state->argv[0], word, why,
                       state->argv[0]);
}

static error_t take(int key, char *text, struct argp_state *state)
{
    const parse_t *p = state->input;
    if (key >= first_key && key < first_key + p->n) {
        const int i = key - first_key;
        if (!take_option(p->option[i], p->into[i], text, p->e)) {
            return EINVAL;
        }
        state->next = *p->is_help ? state->argc : state->next;
        return 0;
    }
    if (key == ARGP_KEY_ERROR && p->e->text[0] == '\0') {
        refuse(p, state);
    }
    if (key != ARGP_KEY_ARG) {
        return ARGP_ERR_UNKNOWN;
    }
    p->rest->argument = text;
    p->rest->n_arguments++;
    return 0;
}

static void add(parse_t *p, const camsim_set_t *set)
{
    for (size_t i = 0; i < set->n && p->n < most_options; i++) {
        const camsim_option_t *o = &set->options[i];
        p->option[p->n] = o;
        p->into[p->n] = set->into;
        p->table[p->n] = (struct argp_option){.name = o->name,
                                              .key = first_key + p->n,
                                              .arg = o->argument,
                                              .doc = o->help,
                                              .group = p->n + 1}; // the help keeps the order
        p->n++;
    }
}

bool camsim_parse(const camsim_set_t *sets, size_t n_sets, int argc, char **argv,
                  const bool *is_help, camsim_rest_t *rest, common_error_t *e)
{
    parse_t p = {.is_help = is_help, .rest = rest, .e = e};
    const struct argp argp = {.options = p.table, .parser = take};
    e->text[0] = '\0';
    for (size_t i = 0; i < n_sets; i++) {
        add(&p, &sets[i]);
    }
    const error_t error =
        argp_parse(&argp, argc, argv, ARGP_NO_ERRS | ARGP_NO_HELP | ARGP_NO_EXIT, NULL, &p);
    if (error != 0 && e->text[0] == '\0') {
        return common_error(e, "not enough memory; free some");
    }
    return error == 0;
}

void camsim_help(const char *name, const char *arguments, const char *text, camsim_set_t set)
{
    parse_t p = {.n = 0};
    char copy[64];
    (void)snprintf(copy, sizeof copy, "%s", name);
    add(&p, &set);
    const struct argp argp = {.options = p.table, .args_doc = arguments, .doc = text};
    argp_help(&argp, stdout,
              ARGP_HELP_SHORT_USAGE | ARGP_HELP_PRE_DOC | ARGP_HELP_LONG | ARGP_HELP_POST_DOC,
              copy);
}
