// SPDX-License-Identifier: Apache-2.0
#include "lin_disk_bench.h"
#include <errno.h>       // EIO
#include <stdint.h>      // INT32_MAX
#include <stdlib.h>      // mkdtemp
#include <sys/syscall.h> // SYS_fsync

char folder[] = "/tmp/test_lin_disk.XXXXXX";
char path[100], fresh[110];
int n_good_syncs = INT32_MAX;

void disk_open(void)
{
    (void)strcpy(strchr(folder, '.') + 1, "XXXXXX");
    if (mkdtemp(folder) == NULL) {
        abort();
    }
    (void)snprintf(path, sizeof path, "%s/file", folder);
    (void)snprintf(fresh, sizeof fresh, "%s.new", path);
}

void disk_begin(void)
{
    n_good_syncs = INT32_MAX;
    (void)unlink(path);
    (void)unlink(fresh);
}

void disk_close(void)
{
    disk_begin();
    (void)rmdir(folder);
}

/// Replaces the library's function.
int fsync(int fd)
{
    if (n_good_syncs-- <= 0) {
        errno = EIO;
        return -1;
    }
    return (int)syscall(SYS_fsync, fd);
}
