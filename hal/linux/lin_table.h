// SPDX-License-Identifier: Apache-2.0
/// lin_table: the table in force and room for the next one, both in locked memory.
///
/// The file holds the table in force. A new one is written beside it and renamed over it, so that a
/// loss of power leaves the old one or the new one. hal.h has the functions.
#ifndef LIN_TABLE_H
#define LIN_TABLE_H

#include "lin_error.h" // lin_error_t
#include <stdbool.h>   // bool
#include <stdint.h>    // int64_t

/// Get the memory, read the file if there is one.
/// @param path       kept by reference
/// @param max_bytes  of one table
/// @return           false and *e: no memory, file unreadable or too large. Context: main(), once.
bool lin_table_open(const char *path, int64_t max_bytes, lin_error_t *e);

#endif
