// SPDX-License-Identifier: Apache-2.0
#include "lin_setup.h"
#include <errno.h>  // errno
#include <fcntl.h>  // open
#include <libgen.h> // dirname
#include <stdio.h>  // rename, snprintf
#include <string.h> // strerror
#include <unistd.h> // read, write, fsync

enum { path_bytes = 256 };

ssize_t lin_file_read(int fd, uint8_t *bytes, uint32_t room)
{
    uint32_t done = 0;
    ssize_t n = 1;
    while (done < room && n > 0) {
        n = read(fd, bytes + done, room - done);
        done += n > 0 ? (uint32_t)n : 0u;
    }
    return n < 0 ? -1 : (ssize_t)done;
}

static bool write_all(int fd, const uint8_t *bytes, uint32_t size)
{
    for (uint32_t done = 0; done < size;) {
        const ssize_t n = write(fd, bytes + done, size - done);
        if (n < 0) {
            return false;
        }
        done += (uint32_t)n;
    }
    return true;
}

/// Close a file; keep errno of an earlier failure.
static bool close_file(int fd, bool is_good)
{
    const int err = errno;
    const bool is_closed = close(fd) == 0;
    errno = is_good ? errno : err;
    return is_closed && is_good;
}

/// Write a new file. First remove a file left by an interrupted run, or a link that would redirect
/// the write to another file.
static bool store(const char *path, const uint8_t *bytes, uint32_t n)
{
    (void)unlink(path);
    const int fd = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
    if (fd < 0) {
        return false;
    }
    const bool is_written = write_all(fd, bytes, n) && fsync(fd) == 0;
    return close_file(fd, is_written);
}

/// Flush the directory entry to disk.
static bool sync_folder(const char *path)
{
    char copy[path_bytes];
    (void)snprintf(copy, sizeof copy, "%s", path);
    const int fd = open(dirname(copy), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    return fd >= 0 && close_file(fd, fsync(fd) == 0);
}

bool lin_file_replace(const char *path, const uint8_t *bytes, uint32_t n, common_error_t *e)
{
    char fresh[path_bytes];
    (void)snprintf(fresh, sizeof fresh, "%s.new", path);
    if (!store(fresh, bytes, n) || rename(fresh, path) != 0) {
        (void)common_error(e, "%s: not written: %s", path, strerror(errno));
        (void)unlink(fresh);
        return false;
    }
    e->text[0] = '\0';
    if (!sync_folder(path)) {
        (void)common_error(e, "%s: in use, but a power failure may restore the old one: %s", path,
                           strerror(errno));
    }
    return true;
}
