// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE // NOLINT(bugprone-reserved-identifier): memfd_create
#include "fuzz_file.h"
#include "fuzz_expect.h" // FUZZ_EXPECT
#include <stdbool.h>     // bool
#include <stdio.h>       // snprintf
#include <sys/mman.h>    // memfd_create
#include <unistd.h>      // ftruncate, pwrite

const char *fuzz_file(const uint8_t *data, size_t size)
{
    static int fd = -1;
    static char path[64];
    if (fd < 0) {
        fd = memfd_create("input", 0);
        (void)snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    }
    const bool is_there =
        fd >= 0 && ftruncate(fd, 0) == 0 && pwrite(fd, data, size, 0) == (ssize_t)size;
    FUZZ_EXPECT(is_there, "no file in memory");
    return path;
}
