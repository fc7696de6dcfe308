// SPDX-License-Identifier: Apache-2.0
/// lcn_table: reads a table file into memory.
#ifndef LCN_TABLE_H
#define LCN_TABLE_H

#include <stdbool.h> // bool
#include <stddef.h>  // size_t

enum { lcn_table_most_bytes = 1 << 26, lcn_table_error_bytes = 256 };

typedef struct {
    void *bytes; ///< aligned for any type, of malloc()
    size_t size; ///< [bytes]
    char error[lcn_table_error_bytes];
} lcn_table_t;

/// @return false and table->error if the file cannot be read completely
bool lcn_table_read(const char *path, lcn_table_t *table);

#endif
