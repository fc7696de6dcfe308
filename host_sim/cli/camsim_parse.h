// SPDX-License-Identifier: Apache-2.0
/// camsim_parse: the options of a command, parsed and listed by argp; errors are one line.
#ifndef CAMSIM_PARSE_H
#define CAMSIM_PARSE_H

#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool
#include <stddef.h>       // size_t

/// An option is a switch (bool) without an argument, a number (double) with a unit, has a function
/// of its own, or is a text (const char *) that is not empty.
typedef struct {
    const char *name, *argument, *help;
    size_t at; ///< where its value is stored in the structure of the options
    const char *unit;
    double min, max; ///< of a number, ends included
    bool is_whole;   ///< number
    bool (*take)(void *options, const char *text, common_error_t *e);
} camsim_option_t;

// A row of the table of each kind.
// clang-format off
#define CAMSIM_SWITCH(name_, at_, help_) {.name = (name_), .help = (help_), .at = (at_)}
#define CAMSIM_TEXT(name_, argument_, at_, help_) \
    {.name = (name_), .argument = (argument_), .help = (help_), .at = (at_)}
#define CAMSIM_TAKEN(name_, argument_, take_, help_) \
    {.name = (name_), .argument = (argument_), .help = (help_), .take = (take_)}
#define CAMSIM_NUMBER(name_, argument_, at_, min_, max_, unit_, help_) \
    {.name = (name_), .argument = (argument_), .help = (help_), .at = (at_), \
     .unit = (unit_), .min = (min_), .max = (max_)}
#define CAMSIM_WHOLE(name_, argument_, at_, min_, max_, help_) \
    {.name = (name_), .argument = (argument_), .help = (help_), .at = (at_), \
     .unit = "a whole number", .min = (min_), .max = (max_), .is_whole = true}
// clang-format on

/// A set of options, and the structure that they fill.
typedef struct {
    const camsim_option_t *options;
    size_t n;
    void *into;
} camsim_set_t;

/// What argp_parse() found besides options.
typedef struct {
    const char *argument; ///< the last one
    int n_arguments;
} camsim_rest_t;

/// Parse the options of all sets, up to the first that sets *is_help.
/// @param argv  argv[0] is the command
/// @return      false and *e when something is wrong
bool camsim_parse(const camsim_set_t *sets, size_t n_sets, int argc, char **argv,
                  const bool *is_help, camsim_rest_t *rest, common_error_t *e);

/// Print the help of a command: usage, what it does, its options, and what comes after a '\v'.
void camsim_help(const char *name, const char *arguments, const char *text, camsim_set_t set);

#endif
