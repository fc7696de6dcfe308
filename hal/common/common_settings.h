// SPDX-License-Identifier: Apache-2.0
/// common_settings: read a settings file into variables, by a list of the allowed keys.
///
/// The format is a subset of TOML:
///
///     # comment
///     [section]
///     key = 1.5          # a number, true, false or "text", all on one line
///
/// Duplicate keys, values of the wrong type and values out of range are refused with file, line,
/// key, value and remedy. Keys not in the list go to the program's handler.
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
    common_setting_text,   ///< char[max + 1]; no backslash, which TOML would interpret
    common_setting_choice, ///< uint32_t: index of the word in `choices`
    common_setting_real,   ///< double; true and false count as 1 and 0
    common_setting_count,  ///< double that holds a whole number
    common_setting_sign,   ///< double that holds a whole number other than 0
} common_setting_kind_t;

/// One key and its variable.
typedef struct {
    const char *section, *key;
    common_setting_kind_t kind;
    size_t offset;       ///< [bytes] of the variable, from `into`
    double min, max;     ///< number: range, within 2^53; text: max is its longest length
    const char *choices; ///< "\"first\" \"second\"", also shown in the message
    double normal;       ///< default, in lists that state defaults
    const char *meaning; ///< for people, likewise
} common_setting_t;

enum { common_settings_max = 128 }; ///< most keys in a list

typedef struct common_settings common_settings_t;

/// Handle a key that is not in the list. @return false and an error if it is refused
typedef bool common_settings_taker_t(const common_settings_t *s, const char *section,
                                     const char *key, const char *text);

/// Description of the file and its messages.
struct common_settings {
    const char *path; ///< for messages
    const common_setting_t *list;
    size_t n;                            ///< keys, at most common_settings_max
    void *into;                          ///< base of the offsets
    common_settings_taker_t *take_other; ///< for keys not in the list
    void *user;                          ///< for take_other
    /// Refuse sections that are not in the list, and inih's ":" for "=" and ";" for "#".
    bool is_strict;
    bool has_line_word; ///< messages begin with "FILE: line 7: ", else with "FILE:7: "
    int value_width;    ///< [characters] most of a value that a message repeats
    int line;           ///< current line
    common_error_t *e;
};

/// Read a file; variables of missing keys keep their values.
/// @param stream  open for reading; stays open
/// @return        false and *s->e on the first error; *s->into may be partly changed
bool common_settings_read(common_settings_t *s, FILE *stream);

/// Refuse a value: "FILE:LINE: section.key = value: why". @return false
bool common_settings_refuse(const common_settings_t *s, const char *section, const char *key,
                            const char *text, const char *why);

/// Refuse a key, perhaps of a file of another kind, whose values nobody should see:
/// "FILE:LINE: section.key: why". @return false
bool common_settings_refuse_key(const common_settings_t *s, const char *section, const char *key,
                                const char *why);

/// Convert a TOML number without underscores; true is 1, false is 0.
bool common_settings_number(const char *text, double *value);

/// Copy a quoted text without its quotes.
/// @param into  [max + 1] characters
/// @return      false if the text is not quoted or longer than max
bool common_settings_text(const char *text, char *into, size_t max);

#endif
