// SPDX-License-Identifier: Apache-2.0
/// lin_params: the parameters that are kept over a restart, in a file of their own.
///
/// A file that cannot be read does not keep the program from starting: the firmware is told that it
/// is damaged, and uses its defaults. The functions are those of hal.h. Context: main().
#ifndef LIN_PARAMS_H
#define LIN_PARAMS_H

#include "hal/hal.h"      // hal_params_t
#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool
#include <stdint.h>       // uint32_t

/// Read the file if there is one.
/// @param path  kept by reference; "": parameters are not kept
/// @param e     text "" when all is well, else why the file cannot be read, or not be replaced
/// later
void lin_params_open(const char *path, common_error_t *e);

/// @return what the file holds
hal_params_t lin_params_kept(void);

/// Replace the file (lin_file_replace()).
/// @param e  text "" when all is well
/// @return   false and *e: it cannot be written, and the old one stays
bool lin_params_keep(const void *bytes, uint32_t size, common_error_t *e);

#endif
