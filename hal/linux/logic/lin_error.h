// SPDX-License-Identifier: Apache-2.0
/// lin_error: the one line that tells a user what is wrong: place, field, value, remedy.
#ifndef LIN_ERROR_H
#define LIN_ERROR_H

#include <stdbool.h> // bool

typedef struct {
    char text[512]; ///< one line without a full stop; control characters of the input replaced
} lin_error_t;

/// Write the line.
/// @return false, so that a check reads: return lin_error(e, "...");
__attribute__((format(printf, 2, 3))) bool lin_error(lin_error_t *e, const char *format, ...);

#endif
