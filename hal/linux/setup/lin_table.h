// SPDX-License-Identifier: Apache-2.0
/// lin_table: the table in use and memory for the next one, both locked, and the file of the table.
///
/// The file is replaced atomically (lin_file_replace()). The functions implement hal.h. Context:
/// main().
#ifndef LIN_TABLE_H
#define LIN_TABLE_H

#include "hal/hal.h"      // hal_image_t
#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool
#include <stdint.h>       // int64_t, uint32_t

/// Allocate the memory and read the file if it exists.
/// @param path       static
/// @param max_bytes  largest table
/// @return           false and *e: out of memory, file unreadable or too large
bool lin_table_open(const char *path, int64_t max_bytes, common_error_t *e);

/// @return the table in use; size 0: none
hal_image_t lin_table_image(void);

/// Begin a download. @return false if larger than max_bytes
bool lin_table_begin(uint32_t size);

/// Write a piece. @return false if outside the table, or no download was begun
bool lin_table_write(uint32_t offset, const void *bytes, uint32_t n);

/// @return the table of the download; size 0: none
hal_image_t lin_table_staged(void);

/// Replace the table in use and its file by the downloaded table. If this fails, it may be
/// repeated.
/// @param e  error, text "" if none
/// @return   false and *e: nothing was begun, or the file cannot be written; the old table remains.
///           True and *e: in use, but a power failure may restore the old one
bool lin_table_commit(common_error_t *e);

#endif
