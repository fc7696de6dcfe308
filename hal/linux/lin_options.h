// SPDX-License-Identifier: Apache-2.0
/// lin_options: the command line. main() is the same for all ports and takes no arguments, so the
/// port reads them from /proc/self/cmdline.
#ifndef LIN_OPTIONS_H
#define LIN_OPTIONS_H

#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool

typedef struct {
    char config[512]; ///< path; by --config, else by CAMTURN_CONFIG
    bool is_help;
    bool is_check; ///< read the configuration and end
} lin_options_t;

/// @return false and *e: unknown word, no configuration named
bool lin_options_read(lin_options_t *o, common_error_t *e);

extern const char lin_options_usage[];

#endif
