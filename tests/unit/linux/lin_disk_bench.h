// SPDX-License-Identifier: Apache-2.0
/// lin_disk_bench: a file in a folder of its own, the next one beside it, and a disk that fails
/// when it is told to. Each program that includes it has one bench.
#ifndef LIN_DISK_BENCH_H
#define LIN_DISK_BENCH_H

#include "common_error.h" // common_error_t
#include "unity.h"        // TEST_ASSERT_NOT_NULL
#include <errno.h>        // EIO
#include <stdio.h>        // fopen
#include <stdlib.h>       // mkdtemp
#include <string.h>       // strstr
#include <sys/stat.h>     // mkdir
#include <sys/syscall.h>  // SYS_fsync
#include <unistd.h>       // unlink, syscall

static common_error_t error;
static char folder[] = "/tmp/test_lin_disk.XXXXXX";
static char path[100], fresh[110];
static int n_good_syncs;

/// Called by Unity before and after all tests.
void suiteSetUp(void)
{
    if (mkdtemp(folder) == NULL) {
        abort();
    }
    (void)snprintf(path, sizeof path, "%s/file", folder);
    (void)snprintf(fresh, sizeof fresh, "%s.new", path);
}

/// An empty folder on a good disk. To be called by setUp().
static inline void disk_begin(void)
{
    n_good_syncs = INT32_MAX;
    (void)unlink(path);
    (void)unlink(fresh);
}

int suiteTearDown(int n_failures)
{
    disk_begin();
    (void)rmdir(folder);
    return n_failures;
}

/// Stands in front of the library's function: a disk that confirms a number of times.
int fsync(int fd)
{
    if (n_good_syncs-- <= 0) {
        errno = EIO;
        return -1;
    }
    return (int)syscall(SYS_fsync, fd);
}

static inline void put_file(const char *at, const char *text)
{
    FILE *file = fopen(at, "w");
    TEST_ASSERT_NOT_NULL(file);
    (void)fputs(text, file);
    (void)fclose(file);
}

#endif
