// SPDX-License-Identifier: Apache-2.0
/// lin_blackbox: the memory of the recorder, and the file beside the table that keeps a black box
/// over a restart.
///
/// What the file holds is for the firmware to judge; a file that is none of ours is told and stays
/// until the next fault replaces it. The functions are those of hal.h. Context: main().
#ifndef LIN_BLACKBOX_H
#define LIN_BLACKBOX_H

#include "hal/hal.h"      // hal_memory_t
#include "common_error.h" // common_error_t
#include <stdint.h>       // int32_t, uint32_t

enum { lin_blackbox_words = 1 << 20 }; ///< 4 MiB

/// Read the file, if there is one, to the begin of the memory.
/// @param table_file  the box is kept in this path with ".blackbox" behind it
/// @param e           text "" when all is well, else why nothing was taken from the file
void lin_blackbox_open(const char *table_file, common_error_t *e);

/// @return the memory, and how much of it came from the file
hal_memory_t lin_blackbox_memory(void);

/// Replace the file (lin_file_replace()), or remove it.
/// @param n  [words] 0: remove it
/// @param e  text "" when all is well
void lin_blackbox_keep(const int32_t *words, uint32_t n, common_error_t *e);

#endif
