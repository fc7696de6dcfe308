// SPDX-License-Identifier: Apache-2.0
/// common_settings: read a file of settings into variables, by a list of what may be in it.
///
/// TOML as far as settings need it:
///
///     # comment
///     [section]
///     key = 1.5          # a number, true, false or "text", all on one line
///
/// Keys that are given twice, values of another kind and values out of range are refused, and the
/// message names file, line, key, value and remedy. What is not in the list goes to the program's
/// own taker, or is refused.
#ifndef COMMON_SETTINGS_H
#define COMMON_SETTINGS_H

#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool
#include <stddef.h>       // size_t
#include <stdint.h>       // uint32_t, int64_t
#include <stdio.h>        // FILE

typedef enum {
    common_setting_whole,  ///< int64_t
    common_setting_flag,   ///< bool
    common_setting_text,   ///< char[max + 1]; without a backslash, which TOML would interpret
    common_setting_choice, ///< uint32_t: number of the word among `choices`
    common_setting_real,   ///< double; true and false count as 1 and 0
    common_setting_count,  ///< double that holds a whole number
    common_setting_sign,   ///< double that holds a whole number other than 0
} common_setting_kind_t;

/// One key, and where its value goes.
typedef struct {
    const char *section, *key;
    common_setting_kind_t kind;
    size_t offset;       ///< [bytes] of the variable in what is filled
    double min, max;     ///< number: its range, within 2^53; text: its length
    const char *choices; ///< "\"first\" \"second\"" as the message lists them
} common_setting_t;

enum { common_settings_max = 128 }; ///< keys of one list

typedef struct common_settings common_settings_t;

/// Takes a key that is not in the list. @return false and an error when it is refused
typedef bool common_settings_taker_t(const common_settings_t *s, const char *section,
                                     const char *key, const char *text);

/// What a program wants read, and how its messages are worded.
struct common_settings {
    const char *path; ///< for messages
    const common_setting_t *list;
    size_t n;                            ///< keys, at most common_settings_max
    void *into;                          ///< what the offsets refer to
    common_settings_taker_t *take_other; ///< NULL: a key that is not in the list is refused
    void *user;                          ///< of take_other
    /// Sections must be those of the list, "=" separates key and value, "#" begins a comment; else
    /// inih's ":" and ";" do so, too.
    bool is_strict;
    bool has_line_word; ///< messages begin with "FILE: line 7: ", else with "FILE:7: "
    int value_width;    ///< [characters] of a value that a message repeats
    int line;           ///< that is being read
    common_error_t *e;
};

/// Read a file over the present values.
/// @param stream  open for reading; stays open
/// @return        false and *s->e on the first thing wrong; *s->into may be partly filled then
bool common_settings_read(common_settings_t *s, FILE *stream);

/// Refuse a value: "FILE:LINE: section.key = value: why". @return false
bool common_settings_refuse(const common_settings_t *s, const char *section, const char *key,
                            const char *text, const char *why);

/// Take a number as TOML writes it, without underscores; true and false count as 1 and 0.
bool common_settings_number(const char *text, double *value);

/// Take the inside of one "text".
/// @param into  [max + 1] characters
/// @return      false when it is no such text or longer than max
bool common_settings_text(const char *text, char *into, size_t max);

#endif
