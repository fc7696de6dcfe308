// SPDX-License-Identifier: Apache-2.0
/// lin_place: location of a GPIO line: CHIP:OFFSET, or a name.
#ifndef LIN_PLACE_H
#define LIN_PLACE_H

#include "lin_config.h"   // lin_name_max
#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool

typedef struct {
    char chip[lin_name_max + 16]; ///< path
    unsigned offset;
    const char *name; ///< NULL: given by offset
} lin_place_t;

/// @param chip   chip for a name: gpiochip0 or a path
/// @param place  name or CHIP:OFFSET; static
/// @return       false and *e if the offset is not a number
bool lin_place_parse(lin_place_t *p, const char *chip, const char *place, common_error_t *e);

/// @return whether both are the same line; a name and an offset are never equal
bool lin_place_is_same(const lin_place_t *a, const lin_place_t *b);

/// Format the error for a line that cannot be requested. @return false
/// @param err  errno
/// @param who  program that uses the line, "" if not known
bool lin_place_refuse(const lin_place_t *p, int err, const char *who, common_error_t *e);

#endif
