// SPDX-License-Identifier: Apache-2.0
#include "lcn_table.h"
#include <errno.h>  // errno
#include <stdio.h>  // fopen, snprintf
#include <stdlib.h> // malloc, free
#include <string.h> // strerror

static bool refuse(lcn_table_t *table, const char *path, const char *why, const char *remedy)
{
    (void)snprintf(table->error, sizeof table->error, "table=%.120s: %s; %s", path, why, remedy);
    return false;
}

/// @return [bytes] size of an open file, negative on error
static long size_of(FILE *file)
{
    const long size = fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
    return fseek(file, 0, SEEK_SET) == 0 ? size : -1;
}

static bool read_whole(FILE *file, const char *path, lcn_table_t *table)
{
    const long size = size_of(file);
    if (size <= 0 || size > (long)lcn_table_most_bytes) {
        return refuse(table, path, "wrong size for a table", "make it with tools/mktables");
    }
    void *bytes = malloc((size_t)size);
    if (bytes == NULL || fread(bytes, 1, (size_t)size, file) != (size_t)size) {
        free(bytes);
        return refuse(table, path, "cannot be read completely", "check disk and memory");
    }
    table->bytes = bytes;
    table->size = (size_t)size;
    return true;
}

bool lcn_table_read(const char *path, lcn_table_t *table)
{
    *table = (lcn_table_t){0};
    if (path[0] == '\0') {
        return refuse(table, path, "no table is given",
                      "loadrt camturn table=/absolute/path/NAME.camtab");
    }
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        return refuse(table, path, strerror(errno),
                      "give the absolute path of a .camtab file of tools/mktables");
    }
    const bool is_read = read_whole(file, path, table);
    (void)fclose(file);
    return is_read;
}
