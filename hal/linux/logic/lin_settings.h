// SPDX-License-Identifier: Apache-2.0
/// lin_settings: read a file of settings into variables, by a list of what may be in it.
///
/// TOML as far as settings need it: [section], key = value with a whole number, true, false or
/// "text" on one line, # comments. Unknown keys and sections, keys given twice, values of another
/// kind or out of range are refused.
#ifndef LIN_SETTINGS_H
#define LIN_SETTINGS_H

#include "lin_error.h" // lin_error_t
#include <stdbool.h>   // bool
#include <stddef.h>    // size_t
#include <stdint.h>    // int64_t

typedef enum {
    lin_setting_whole,  ///< int64_t
    lin_setting_flag,   ///< bool
    lin_setting_text,   ///< char[max + 1]
    lin_setting_choice, ///< uint32_t: number of the word among `choices`
} lin_setting_kind_t;

/// One key, and where its value goes.
typedef struct {
    const char *section, *key;
    lin_setting_kind_t kind;
    size_t offset;       ///< [bytes] of the variable in what is filled
    int64_t min, max;    ///< whole number: its range; text: its length
    const char *choices; ///< "\"first\" \"second\"" as it is told to the user
} lin_setting_t;

enum { lin_settings_max = 64 }; ///< keys of one list

/// Read a file over the present values.
/// @param list  n <= lin_settings_max keys
/// @param into  what the offsets refer to
/// @return      false and *e on the first thing wrong; *into may be partly filled then
bool lin_settings_read(const char *path, const lin_setting_t *list, size_t n, void *into,
                       lin_error_t *e);

#endif
