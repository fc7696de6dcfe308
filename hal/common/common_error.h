// SPDX-License-Identifier: Apache-2.0
/// common_error: a one-line error message for the user: file, field, value, remedy.
#ifndef COMMON_ERROR_H
#define COMMON_ERROR_H

#include <stdbool.h> // bool

typedef struct {
    char text[512]; ///< one line without a full stop; control characters of the input are replaced
} common_error_t;

/// Format the message. @return false, for "return common_error(e, ...)" in checks
__attribute__((format(printf, 2, 3))) bool common_error(common_error_t *e, const char *format, ...);

#endif
