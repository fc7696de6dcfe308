// SPDX-License-Identifier: Apache-2.0
/// lin_halt_text: the reason of a hal_halt() is kept for the next start of the program, in a file
/// beside the table.
#ifndef LIN_HALT_TEXT_H
#define LIN_HALT_TEXT_H

#include "hal/hal.h" // hal_start_t

enum { lin_halt_text_bytes = 100 }; ///< a longer reason is cut off

/// Read the reason that the last run left, and remove it.
/// @param table_file  the reason is kept in this path with ".halt" behind it
hal_start_t lin_halt_text_start(const char *table_file);

/// Leave a reason for the next start, unless a link lies in its place. Context: any.
void lin_halt_text_halt(const char *why);

#endif
