// SPDX-License-Identifier: Apache-2.0
#include "hal/hal.h" // lin_table_*
#include "lin_setup.h"
#include <errno.h>    // errno
#include <fcntl.h>    // open
#include <stdlib.h>   // aligned_alloc
#include <string.h>   // memcpy
#include <sys/stat.h> // fstat
#include <unistd.h>   // close

enum { alignment = 64, erased = 0xFF };

typedef struct {
    uint8_t *bytes; ///< [room]
    uint32_t size;  ///< [bytes] of the image
} bank_t;

static struct {
    const char *path;
    uint32_t room;
    bank_t banks[2];
    int i_active;
    bool is_begun; ///< the other bank is being written
} table;

static bank_t *other(void)
{
    return &table.banks[1 - table.i_active];
}

static bool load(int fd, common_error_t *e)
{
    struct stat about;
    if (fstat(fd, &about) != 0 || !S_ISREG(about.st_mode)) {
        return common_error(e, "%s: not a file; give the path of a table", table.path);
    }
    if (about.st_size > (off_t)table.room) {
        return common_error(e, "%s: %lld bytes; raise table.max_bytes", table.path,
                            (long long)about.st_size);
    }
    bank_t *bank = &table.banks[table.i_active];
    if (lin_file_read(fd, bank->bytes, (uint32_t)about.st_size) != about.st_size) {
        return common_error(e, "%s: cannot be read: %s", table.path, strerror(errno));
    }
    bank->size = (uint32_t)about.st_size;
    return true;
}

bool lin_table_open(const char *path, int64_t max_bytes, common_error_t *e)
{
    for (int i = 0; i < 2; i++) { // of an earlier call
        free(table.banks[i].bytes);
    }
    memset(&table, 0, sizeof table);
    table.path = path;
    table.room = (uint32_t)((max_bytes + alignment - 1) / alignment * alignment);
    for (int i = 0; i < 2; i++) {
        table.banks[i].bytes = aligned_alloc(alignment, table.room);
        if (table.banks[i].bytes == NULL) {
            return common_error(e, "table.max_bytes = %lld: no memory; give less",
                                (long long)max_bytes);
        }
        (void)memset(table.banks[i].bytes, erased,
                     table.room); // touch every page: no page fault in a tick
    }
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0) {
        return errno == ENOENT ||
               common_error(e, "%s: cannot be opened: %s", path, strerror(errno));
    }
    const bool is_loaded = load(fd, e);
    (void)close(fd);
    return is_loaded;
}

hal_image_t lin_table_image(void)
{
    const bank_t *bank = &table.banks[table.i_active];
    return (hal_image_t){.bytes = bank->bytes, .size = bank->size};
}

bool lin_table_begin(uint32_t size)
{
    if (size == 0u || size > table.room) {
        return false;
    }
    bank_t *bank = other();
    (void)memset(bank->bytes, erased, table.room);
    bank->size = size;
    table.is_begun = true;
    return true;
}

bool lin_table_write(uint32_t offset, const void *bytes, uint32_t n)
{
    const bank_t *bank = other();
    if (!table.is_begun || offset > bank->size || n > bank->size - offset) {
        return false;
    }
    (void)memcpy(bank->bytes + offset, bytes, n);
    return true;
}

hal_image_t lin_table_staged(void)
{
    return table.is_begun ? (hal_image_t){.bytes = other()->bytes, .size = other()->size}
                          : (hal_image_t){.bytes = NULL, .size = 0};
}

bool lin_table_commit(common_error_t *e)
{
    if (!table.is_begun) {
        return common_error(e, "no table download was begun");
    }
    if (!lin_file_replace(table.path, other()->bytes, other()->size, e)) {
        return false;
    }
    table.is_begun = false;
    table.i_active = 1 - table.i_active;
    return true;
}
