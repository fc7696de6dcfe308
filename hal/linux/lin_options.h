// SPDX-License-Identifier: Apache-2.0
/// lin_options: the command line, read from /proc/self/cmdline, because the common main() has no
/// arguments.
#ifndef LIN_OPTIONS_H
#define LIN_OPTIONS_H

#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool

typedef struct {
    char config[512];  ///< path from --config, else from CAMTURN_CONFIG
    const char *print; ///< --help or --version: text to print before exiting, else NULL
    bool is_check;     ///< check the configuration and exit
} lin_options_t;

/// @return false and *e: unknown option, or no configuration given
bool lin_options_read(lin_options_t *o, common_error_t *e);

#endif
