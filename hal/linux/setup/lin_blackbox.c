// SPDX-License-Identifier: Apache-2.0
#include "lin_setup.h"
#include <errno.h>  // errno
#include <fcntl.h>  // open
#include <stdio.h>  // snprintf
#include <string.h> // strerror
#include <unistd.h> // close, unlink

enum { path_bytes = 256, word_bytes = sizeof(int32_t) };

static struct {
    char path[path_bytes];
    int32_t words[lin_blackbox_words + 1]; ///< one more, to detect a longer file
    uint32_t n_kept;
} box;

static void load(int fd, common_error_t *e)
{
    const ssize_t n = lin_file_read(fd, (uint8_t *)box.words, sizeof box.words);
    if (n < 0) {
        (void)common_error(e, "%s: cannot be read: %s", box.path, strerror(errno));
    } else if (n % word_bytes != 0 || n > (ssize_t)lin_blackbox_words * word_bytes) {
        (void)common_error(e, "%s: not a black box; remove it", box.path);
    } else {
        box.n_kept = (uint32_t)(n / word_bytes);
    }
}

void lin_blackbox_open(const char *table_file, common_error_t *e)
{
    (void)snprintf(box.path, sizeof box.path, "%s.blackbox", table_file);
    box.n_kept = 0;
    e->text[0] = '\0';
    const int fd = open(box.path, O_RDONLY | O_CLOEXEC);
    if (fd >= 0) {
        load(fd, e);
        (void)close(fd);
    } else if (errno != ENOENT) {
        (void)common_error(e, "%s: cannot be opened: %s", box.path, strerror(errno));
    }
}

hal_memory_t lin_blackbox_memory(void)
{
    return (hal_memory_t){.words = box.words, .n_words = lin_blackbox_words, .n_kept = box.n_kept};
}

void lin_blackbox_keep(const int32_t *words, uint32_t n, common_error_t *e)
{
    e->text[0] = '\0';
    if (n > 0u) {
        (void)lin_file_replace(box.path, (const uint8_t *)words, n * (uint32_t)word_bytes, e);
    } else if (unlink(box.path) != 0 && errno != ENOENT) {
        (void)common_error(e, "%s: cannot be removed: %s", box.path, strerror(errno));
    }
}
