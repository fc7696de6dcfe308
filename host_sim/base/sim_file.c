// SPDX-License-Identifier: Apache-2.0
#define _POSIX_C_SOURCE 200809L // NOLINT(bugprone-reserved-identifier): stat
#include "sim_file.h"
#include <errno.h>    // errno
#include <stdio.h>    // fopen
#include <stdlib.h>   // aligned_alloc, free
#include <string.h>   // memcpy, strerror
#include <sys/stat.h> // stat

enum { first_bytes = 65536, alignment = 32 };

void sim_file_free(sim_file_t *f)
{
    free(f->bytes);
    *f = (sim_file_t){0};
}

static bool grow(sim_file_t *f, size_t capacity)
{
    uint8_t *bytes = aligned_alloc(alignment, capacity);
    if (bytes == NULL) {
        return false;
    }
    if (f->size > 0u) {
        memcpy(bytes, f->bytes, f->size);
    }
    free(f->bytes);
    f->bytes = bytes;
    return true;
}

/// The buffer grows while the file is read, so a file that grows meanwhile is read in full.
static bool read_all(sim_file_t *f, FILE *stream, const char *path, size_t max_bytes,
                     common_error_t *e)
{
    for (size_t capacity = first_bytes;; capacity *= 2u) {
        if (!grow(f, capacity)) {
            return common_error(e, "%s: not enough memory for %zu bytes; use a smaller file", path,
                                capacity);
        }
        f->size += fread(f->bytes + f->size, 1, capacity - f->size, stream);
        if (ferror(stream) != 0) {
            return common_error(e, "%s: cannot be read: %s; give a readable file", path,
                                strerror(errno));
        }
        if (f->size > max_bytes) {
            return common_error(e, "%s: larger than %zu bytes; give the right file", path,
                                max_bytes);
        }
        if (f->size < capacity) {
            return true;
        }
    }
}

/// Open a regular file only: a pipe would block, and a device may never end.
static FILE *open_regular(const char *path, common_error_t *e)
{
    struct stat about;
    const bool is_there = stat(path, &about) == 0;
    if (is_there && !S_ISREG(about.st_mode)) {
        (void)common_error(e, "%s: %s; give a file", path,
                           S_ISDIR(about.st_mode) ? "is a folder" : "is not a regular file");
        return NULL;
    }
    FILE *stream = is_there ? fopen(path, "rb") : NULL;
    if (stream == NULL) {
        (void)common_error(e, "%s: cannot be opened: %s; check the path", path, strerror(errno));
    }
    return stream;
}

bool sim_file_read(sim_file_t *f, const char *path, size_t max_bytes, common_error_t *e)
{
    *f = (sim_file_t){0};
    FILE *stream = open_regular(path, e);
    if (stream == NULL) {
        return false;
    }
    const bool is_good = read_all(f, stream, path, max_bytes, e);
    (void)fclose(stream);
    if (!is_good) {
        sim_file_free(f);
    }
    return is_good;
}
