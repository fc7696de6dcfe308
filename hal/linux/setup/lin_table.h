// SPDX-License-Identifier: Apache-2.0
/// lin_table: the table in force and room for the next one, both in locked memory.
///
/// The file holds the table in force. A new one is written beside it and renamed over it, so that a
/// loss of power leaves the old one or the new one. The functions are those of hal.h, one each.
/// Context: main().
#ifndef LIN_TABLE_H
#define LIN_TABLE_H

#include "hal/hal.h"      // hal_image_t
#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool
#include <stdint.h>       // int64_t, uint32_t

/// Get the memory, read the file if there is one.
/// @param path       kept by reference
/// @param max_bytes  of one table
/// @return           false and *e: no memory, file unreadable or too large
bool lin_table_open(const char *path, int64_t max_bytes, common_error_t *e);

/// @return the table in force; size 0: none
hal_image_t lin_table_image(void);

/// Make room for the next one. @return false: larger than max_bytes
bool lin_table_begin(uint32_t size);

/// Write a piece of it. @return false: outside of it, or not begun
bool lin_table_write(uint32_t offset, const void *bytes, uint32_t n);

/// @return the table that was begun; size 0: none
hal_image_t lin_table_staged(void);

/// Put the table that was begun in force, here and in the file, and wait for the disk. The renaming
/// of the file decides: before it the old table stays, here and in the file, and the new one may be
/// committed again; behind it the new table is in force, also when the disk does not confirm the
/// folder.
/// @param e  text "" when all is well
/// @return   false and *e: nothing was begun, or the file cannot be written; the old one stays.
///           True and *e: a loss of power may bring the old one back
bool lin_table_commit(common_error_t *e);

#endif
