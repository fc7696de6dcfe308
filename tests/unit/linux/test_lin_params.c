// SPDX-License-Identifier: Apache-2.0
// The Linux port's kept parameters: their file, and a disk or a folder that does not take it.
#include "lin_setup.h"
#include "lin_disk_bench.h"
#include <errno.h>       // EROFS
#include <sys/syscall.h> // SYS_access

static bool is_read_only;

void setUp(void)
{
    disk_begin();
    is_read_only = false;
    lin_params_open(path, &error);
}

/// In front of the library's as well: root may write everywhere, a service may not.
int access(const char *name, int mode)
{
    if (is_read_only && (mode & W_OK) != 0) {
        errno = EROFS;
        return -1;
    }
    return (int)syscall(SYS_access, name, mode);
}

static void expect_kept(const char *text)
{
    const hal_params_t kept = lin_params_kept();
    TEST_ASSERT_EQUAL_UINT32(strlen(text), kept.size);
    TEST_ASSERT_EQUAL_MEMORY(text, kept.bytes, kept.size);
    TEST_ASSERT_FALSE(kept.is_damaged);
}

static void keep_first(void)
{
    TEST_ASSERT_TRUE(lin_params_keep("first", 5, &error));
    TEST_ASSERT_EQUAL_STRING("", error.text);
}

static void test_keep_is_found_by_the_next_start(void)
{
    TEST_ASSERT_EQUAL_STRING("", error.text); // no file is nothing wrong
    TEST_ASSERT_EQUAL_UINT32(0, lin_params_kept().size);
    TEST_ASSERT_FALSE(lin_params_kept().is_damaged);
    keep_first();
    expect_kept("first");
    TEST_ASSERT_TRUE(lin_params_keep("second one", 10, &error));
    lin_params_open(path, &error);
    expect_kept("second one");
    TEST_ASSERT_NOT_EQUAL_INT(0, access(fresh, F_OK));
}

static void expect_not_kept(const char *why)
{
    TEST_ASSERT_FALSE(lin_params_keep("second", 6, &error));
    expect_error(why);
    expect_kept("first");
}

/// The start, not only the save, reports a read-only folder.
static void test_keep_that_fails_leaves_the_old_ones(void)
{
    keep_first();
    put_file(fresh, "sec"); // the supply fell while it was written
    lin_params_open(path, &error);
    expect_kept("first");
    n_good_syncs = 0;
    expect_not_kept("not written: Input/output error");
    n_good_syncs = 1;
    TEST_ASSERT_EQUAL_INT(0, mkdir(fresh, 0700)); // a folder blocks the path, also for root
    expect_not_kept("not written");
    TEST_ASSERT_EQUAL_INT(0, rmdir(fresh));
    is_read_only = true;
    lin_params_open(path, &error);
    expect_error("parameters cannot be saved: folder: Read-only");
    expect_kept("first");
    TEST_ASSERT_TRUE(lin_params_keep("second", 6, &error)); // only its folder is not confirmed
    expect_error("a power failure may restore the old one");
    expect_kept("second");
}

static void test_file_that_cannot_be_read_is_damage(void)
{
    static char large[hal_params_most_bytes + 2];
    memset(large, 'x', sizeof large - 1u);
    put_file(path, large);
    lin_params_open(path, &error);
    expect_error("more than 16384 bytes; remove it");
    TEST_ASSERT_TRUE(lin_params_kept().is_damaged);
    TEST_ASSERT_EQUAL_UINT32(0, lin_params_kept().size);
    TEST_ASSERT_FALSE(lin_params_keep(large, sizeof large - 1u, &error));
    lin_params_open(folder, &error);
    expect_error("cannot be read: Is a directory");
    TEST_ASSERT_TRUE(lin_params_kept().is_damaged);
    lin_params_open("", &error);
    TEST_ASSERT_EQUAL_STRING("", error.text);
    TEST_ASSERT_FALSE(lin_params_keep("first", 5, &error));
    expect_error("parameters.file is empty");
}
