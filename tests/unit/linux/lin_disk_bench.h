// SPDX-License-Identifier: Apache-2.0
/// lin_disk_bench: a file in a folder of its own, the next one beside it, and a disk that fails
/// on request.
#ifndef LIN_DISK_BENCH_H
#define LIN_DISK_BENCH_H

#include "unity.h"    // TEST_ASSERT_NOT_NULL
#include <stdio.h>    // fopen
#include <string.h>   // strstr
#include <sys/stat.h> // mkdir
#include <unistd.h>   // unlink

extern char folder[], path[100], fresh[110];
extern int n_good_syncs; ///< fsync() confirms that many times more, then fails

/// Make the folder.
void disk_open(void);

/// Empty the folder, on a good disk.
void disk_begin(void);

/// Remove the folder.
void disk_close(void);

static inline void put_file(const char *at, const char *text)
{
    FILE *file = fopen(at, "w");
    TEST_ASSERT_NOT_NULL(file);
    (void)fputs(text, file);
    (void)fclose(file);
}

#endif
