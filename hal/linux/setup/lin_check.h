// SPDX-License-Identifier: Apache-2.0
/// lin_check: checks the consistency of a configuration. Only the file is checked, not the machine.
#ifndef LIN_CHECK_H
#define LIN_CHECK_H

#include "common_error.h" // common_error_t
#include "lin_config.h"   // lin_config_t
#include <stdbool.h>      // bool

/// Read a file into *config (missing keys keep their values) and check that its values are
/// consistent.
/// @return false and *e on the first error: field, value, remedy
bool lin_check_load(lin_config_t *config, const char *path, common_error_t *e);

/// Prints a line.
typedef void lin_check_report_t(const char *line);

/// Report doubtful values, one line each, beginning with "warning: ".
void lin_check_warn(const lin_config_t *config, lin_check_report_t *report);

#endif
