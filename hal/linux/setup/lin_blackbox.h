// SPDX-License-Identifier: Apache-2.0
/// lin_blackbox: memory of the recorder, and the file that stores a black box across a restart.
///
/// The firmware checks the content. A file of the wrong size is reported and stays until the next
/// fault replaces it. The functions implement hal.h. Context: main().
#ifndef LIN_BLACKBOX_H
#define LIN_BLACKBOX_H

#include "hal/hal.h"      // hal_memory_t
#include "common_error.h" // common_error_t
#include <stdint.h>       // int32_t, uint32_t

enum { lin_blackbox_words = 1 << 20 }; ///< 4 MiB

/// Read the file, if it exists, to the start of the memory.
/// @param table_file  path of the table; ".blackbox" is appended
/// @param e           error, text "" if none
void lin_blackbox_open(const char *table_file, common_error_t *e);

/// @return the memory, and the number of words read from the file
hal_memory_t lin_blackbox_memory(void);

/// Replace the file (lin_file_replace()), or remove it.
/// @param n  [words] 0: remove it
/// @param e  error, text "" if none
void lin_blackbox_keep(const int32_t *words, uint32_t n, common_error_t *e);

#endif
