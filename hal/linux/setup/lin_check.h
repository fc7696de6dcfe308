// SPDX-License-Identifier: Apache-2.0
/// lin_check: whether the values of a configuration fit one another, and whether a machine can work
/// by them. Only the file is checked, not the machine.
#ifndef LIN_CHECK_H
#define LIN_CHECK_H

#include "common_error.h" // common_error_t
#include "lin_config.h"   // lin_config_t
#include <stdbool.h>      // bool

/// Read a file over *config and check that its values fit one another.
/// @return false and *e on the first thing that is wrong or cannot work: field, value, remedy
bool lin_check_load(lin_config_t *config, const char *path, common_error_t *e);

/// A function that takes a line for people.
typedef void lin_check_tell_t(const char *line);

/// Report what works but is doubtful: a line each, beginning with "warning: ".
void lin_check_warn(const lin_config_t *config, lin_check_tell_t *tell);

#endif
