// SPDX-License-Identifier: Apache-2.0
/// sim_error: the one line that tells a user what is wrong: file, field, value, remedy.
#ifndef SIM_ERROR_H
#define SIM_ERROR_H

#include <stdbool.h> // bool

typedef struct {
    char text[512]; ///< one line without a full stop; control characters of the input replaced
} sim_error_t;

/// Write the line.
/// @return false, so that a check reads: return sim_error(e, "...");
__attribute__((format(printf, 2, 3))) bool sim_error(sim_error_t *e, const char *format, ...);

/// Read a decimal number: the whole text, finite, no hexadecimal, no "inf" or "nan".
bool sim_parse_number(const char *text, double *value);

#endif
