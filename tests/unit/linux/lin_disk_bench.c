// SPDX-License-Identifier: Apache-2.0
#include <errno.h>       // EIO
#include <stdint.h>      // INT32_MAX
#include <sys/syscall.h> // SYS_fsync
#include <unistd.h>      // syscall

extern int n_good_syncs;
int n_good_syncs = INT32_MAX;

/// Replaces the library's function.
int fsync(int fd)
{
    if (n_good_syncs-- <= 0) {
        errno = EIO;
        return -1;
    }
    return (int)syscall(SYS_fsync, fd);
}
