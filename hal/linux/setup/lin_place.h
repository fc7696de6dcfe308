// SPDX-License-Identifier: Apache-2.0
/// lin_place: the place of a line: CHIP:OFFSET, or a name.
#ifndef LIN_PLACE_H
#define LIN_PLACE_H

#include "lin_config.h"   // lin_name_max
#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool

typedef struct {
    char chip[lin_name_max + 16]; ///< path
    unsigned offset;
    const char *name; ///< NULL: the place is the offset
} lin_place_t;

/// @param chip   gpiochip0 or a path, for a name
/// @param place  name or CHIP:OFFSET; kept by reference
/// @return       false and *e when the offset is no number
bool lin_place_parse(lin_place_t *p, const char *chip, const char *place, common_error_t *e);

/// @return whether two places name the same line; a name and an offset are not compared
bool lin_place_is_same(const lin_place_t *a, const lin_place_t *b);

/// Word the error of a line that cannot be taken.
/// @param err  errno
/// @param who  its present user, "" when not known
bool lin_place_refuse(const lin_place_t *p, int err, const char *who, common_error_t *e);

#endif
