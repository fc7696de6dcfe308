// SPDX-License-Identifier: Apache-2.0
/// lin_disk_bench: a file in a folder of its own, made for the tests of a file, the next one beside
/// it, and a disk that fails on request.
#ifndef LIN_DISK_BENCH_H
#define LIN_DISK_BENCH_H

#include "common_error.h" // common_error_t
#include "unity.h"        // TEST_ASSERT_NOT_NULL
#include <stdint.h>       // INT32_MAX
#include <stdio.h>        // fopen
#include <stdlib.h>       // abort, mkdtemp
#include <string.h>       // strstr
#include <sys/stat.h>     // mkdir
#include <unistd.h>       // unlink

extern int n_good_syncs; ///< fsync() confirms that many times more, then fails
static char folder[] = "/tmp/test_lin_disk.XXXXXX";
static char path[100], fresh[110];
static common_error_t error;

/// Called by Unity before the first test of a file.
void suiteSetUp(void)
{
    if (mkdtemp(folder) == NULL) {
        abort();
    }
    (void)snprintf(path, sizeof path, "%s/file", folder);
    (void)snprintf(fresh, sizeof fresh, "%s.new", path);
}

/// Empty the folder, on a good disk.
static inline void disk_begin(void)
{
    n_good_syncs = INT32_MAX;
    (void)unlink(path);
    (void)unlink(fresh);
}

/// Called by Unity after the last test of a file.
int suiteTearDown(int n_failures)
{
    disk_begin();
    (void)rmdir(folder);
    return n_failures;
}

static inline void put_file(const char *at, const char *text)
{
    FILE *file = fopen(at, "w");
    TEST_ASSERT_NOT_NULL(file);
    (void)fputs(text, file);
    (void)fclose(file);
}

static inline void expect_error(const char *part)
{
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error.text, part), error.text);
}

#endif
