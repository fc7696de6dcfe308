// SPDX-License-Identifier: Apache-2.0
/// lin_params: the file of stored parameters.
///
/// If it cannot be read, the program still starts: it reports the parameters as damaged and the
/// firmware uses its defaults. The functions implement hal.h. Context: main().
#ifndef LIN_PARAMS_H
#define LIN_PARAMS_H

#include "hal/hal.h"      // hal_params_t
#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool
#include <stdint.h>       // uint32_t

/// Read the file if it exists.
/// @param path  static; "": parameters are not stored
/// @param e     error (the file cannot be read now, or replaced later), text "" if none
void lin_params_open(const char *path, common_error_t *e);

/// @return content of the file
hal_params_t lin_params_kept(void);

/// Replace the file (lin_file_replace()).
/// @param e  error, text "" if none
/// @return   false and *e: the file cannot be written and the old one remains
bool lin_params_keep(const void *bytes, uint32_t size, common_error_t *e);

#endif
