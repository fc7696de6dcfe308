// SPDX-License-Identifier: Apache-2.0
/// common_error: the one line that tells a user what is wrong: file, field, value, remedy.
#ifndef COMMON_ERROR_H
#define COMMON_ERROR_H

#include <stdbool.h> // bool

typedef struct {
    char text[512]; ///< one line without a full stop; control characters of the input are replaced
} common_error_t;

/// Write the line.
/// @return false, so that a check reads: return common_error(e, "...");
__attribute__((format(printf, 2, 3))) bool common_error(common_error_t *e, const char *format, ...);

#endif
