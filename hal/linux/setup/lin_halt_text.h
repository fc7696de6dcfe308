// SPDX-License-Identifier: Apache-2.0
/// lin_halt_text: stores the reason of a hal_halt() in a file for the next start.
#ifndef LIN_HALT_TEXT_H
#define LIN_HALT_TEXT_H

#include "hal/hal.h" // hal_start_t

enum { lin_halt_text_bytes = 100 }; ///< a longer reason is cut off

/// Read and remove the reason of the last run.
/// @param table_file  path of the table; ".halt" is appended
hal_start_t lin_halt_text_start(const char *table_file);

/// Store a reason for the next start; not if the file is a symbolic link. Context: any.
void lin_halt_text_halt(const char *why);

#endif
