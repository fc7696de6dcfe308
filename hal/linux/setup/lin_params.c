// SPDX-License-Identifier: Apache-2.0
#include "lin_setup.h"
#include <errno.h>  // errno
#include <fcntl.h>  // open
#include <libgen.h> // dirname
#include <stdio.h>  // snprintf
#include <string.h> // memcpy, strerror
#include <unistd.h> // access, close

enum { path_bytes = 256 };

static struct {
    const char *path;
    uint8_t bytes[hal_params_most_bytes + 1]; ///< one more, to detect a longer file
    hal_params_t kept;
} params;

/// @return whether the file can be replaced
static bool is_replaceable(const char *path)
{
    char copy[path_bytes];
    (void)snprintf(copy, sizeof copy, "%s", path);
    return access(dirname(copy), W_OK) == 0;
}

static void load(int fd, common_error_t *e)
{
    const ssize_t n = lin_file_read(fd, params.bytes, sizeof params.bytes);
    params.kept.is_damaged = n < 0 || n > (ssize_t)hal_params_most_bytes;
    if (n < 0) {
        (void)common_error(e, "%s: cannot be read: %s", params.path, strerror(errno));
    } else if (params.kept.is_damaged) {
        (void)common_error(e, "%s: more than %d bytes; remove it", params.path,
                           (int)hal_params_most_bytes);
    } else {
        params.kept.bytes = (const char *)params.bytes;
        params.kept.size = (uint32_t)n;
    }
}

void lin_params_open(const char *path, common_error_t *e)
{
    params.path = path;
    params.kept = (hal_params_t){.size = 0};
    e->text[0] = '\0';
    if (path[0] == '\0') {
        return;
    }
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd >= 0) {
        load(fd, e);
        (void)close(fd);
    } else if (errno != ENOENT) {
        params.kept.is_damaged = true;
        (void)common_error(e, "%s: cannot be opened: %s", path, strerror(errno));
    }
    if (e->text[0] == '\0' && !is_replaceable(path)) {
        (void)common_error(e, "%s: parameters cannot be saved: folder: %s", path, strerror(errno));
    }
}

hal_params_t lin_params_kept(void)
{
    return params.kept;
}

bool lin_params_keep(const void *bytes, uint32_t size, common_error_t *e)
{
    if (params.path[0] == '\0') {
        return common_error(e, "parameters are not saved: parameters.file is empty");
    }
    if (size == 0u || size > (uint32_t)hal_params_most_bytes) {
        return common_error(e, "%s: %u bytes do not fit", params.path, (unsigned)size);
    }
    if (!lin_file_replace(params.path, (const uint8_t *)bytes, size, e)) {
        return false;
    }
    (void)memcpy(params.bytes, bytes, size);
    params.kept = (hal_params_t){.bytes = (const char *)params.bytes, .size = size};
    return true;
}
