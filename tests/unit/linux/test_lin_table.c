// SPDX-License-Identifier: Apache-2.0
// The Linux port's table: its file, the next one beside it, and a disk that fails at each step.
#include "lin_setup.h"
#include "lin_disk_bench.h"

void setUp(void)
{
    disk_begin();
}

/// Table in memory and in the file.
static void expect_table(const char *text)
{
    char read[100] = "";
    FILE *file = fopen(path, "r");
    TEST_ASSERT_NOT_NULL(file);
    TEST_ASSERT_EQUAL_size_t(strlen(text), fread(read, 1, sizeof read - 1u, file));
    (void)fclose(file);
    TEST_ASSERT_EQUAL_STRING(text, read);
    const hal_image_t image = lin_table_image();
    TEST_ASSERT_EQUAL_UINT32(strlen(text), image.size);
    TEST_ASSERT_EQUAL_MEMORY(text, image.bytes, image.size);
}

static void open_table(void)
{
    TEST_ASSERT_TRUE(lin_table_open(path, 64, &error));
}

static void begin_second(void)
{
    put_file(path, "first");
    open_table();
    TEST_ASSERT_TRUE(lin_table_begin(6));
    TEST_ASSERT_TRUE(lin_table_write(0, "second", 6));
}

/// Commit, which is not possible: the old table stays.
static void expect_no_commit(const char *why)
{
    TEST_ASSERT_FALSE(lin_table_commit(&error));
    expect_error(why);
    expect_table("first");
}

static void test_table_is_read_at_the_start(void)
{
    open_table(); // none: nothing wrong
    TEST_ASSERT_EQUAL_UINT32(0, lin_table_image().size);
    put_file(path, "first");
    open_table();
    expect_table("first");
    TEST_ASSERT_EQUAL_UINT32(0, (uintptr_t)lin_table_image().bytes % 32u);
    TEST_ASSERT_EQUAL_UINT32(0, lin_table_staged().size);
}

static void test_table_that_cannot_be_read_is_reported(void)
{
    put_file(path, "12345678901234567890123456789012345678901234567890123456789012345");
    TEST_ASSERT_TRUE(lin_table_open(path, 65, &error));
    TEST_ASSERT_FALSE(lin_table_open(path, 64, &error));
    expect_error("65 bytes; raise table.max_bytes");
    TEST_ASSERT_FALSE(lin_table_open(folder, 64, &error));
    expect_error("not a file");
}

static void test_new_table_comes_into_force_by_commit_only(void)
{
    put_file(path, "first");
    open_table();
    TEST_ASSERT_FALSE(lin_table_begin(0));
    TEST_ASSERT_FALSE(lin_table_begin(65));
    TEST_ASSERT_FALSE(lin_table_write(0, "x", 1)); // not begun
    TEST_ASSERT_FALSE(lin_table_commit(&error));
    TEST_ASSERT_TRUE(lin_table_begin(64));
    TEST_ASSERT_TRUE(lin_table_begin(6));
    TEST_ASSERT_TRUE(lin_table_write(0, "sec", 3));
    TEST_ASSERT_FALSE(lin_table_write(4, "ond", 3)); // one behind the end
    TEST_ASSERT_FALSE(lin_table_write(UINT32_MAX, "o", 2));
    TEST_ASSERT_EQUAL_HEX8(0xFF, ((const uint8_t *)lin_table_staged().bytes)[5]);
    TEST_ASSERT_TRUE(lin_table_write(3, "ond", 3));
    expect_table("first");
    TEST_ASSERT_TRUE(lin_table_commit(&error));
    expect_table("second");
    TEST_ASSERT_FALSE(lin_table_commit(&error)); // once
    open_table();                                // the next start
    expect_table("second");
}

static void test_interrupted_download_leaves_the_old_table(void)
{
    begin_second();
    put_file(fresh, "torn"); // the supply fell while it was written
    open_table();
    expect_table("first");
    TEST_ASSERT_EQUAL_UINT32(0, lin_table_staged().size);
}

static void test_table_that_cannot_be_stored_leaves_the_old_one(void)
{
    begin_second();
    TEST_ASSERT_EQUAL_INT(0, mkdir(fresh, 0700)); // a folder blocks the path, also for root
    expect_no_commit("not written");
    TEST_ASSERT_EQUAL_INT(0, rmdir(fresh));
    n_good_syncs = 0;
    expect_no_commit("not written: Input/output error");
    TEST_ASSERT_NOT_EQUAL_INT(0, access(fresh, F_OK));
    n_good_syncs = INT32_MAX;
    TEST_ASSERT_TRUE(lin_table_commit(&error)); // again
    TEST_ASSERT_EQUAL_STRING("", error.text);
    expect_table("second");
}

/// Who may write into the folder may not have a file of somebody else overwritten.
static void test_a_link_in_the_place_of_the_new_file_is_not_followed(void)
{
    char other[110];
    (void)snprintf(other, sizeof other, "%s.other", path);
    begin_second();
    put_file(other, "of somebody else");
    TEST_ASSERT_EQUAL_INT(0, symlink(other, fresh));
    TEST_ASSERT_TRUE(lin_table_commit(&error));
    expect_table("second");
    TEST_ASSERT_EQUAL_INT(0, rename(other, path));
    open_table();
    expect_table("of somebody else");
}

/// After the renaming memory and file must agree, even when the disk does not confirm the folder.
static void test_folder_that_is_not_confirmed_is_reported(void)
{
    begin_second();
    n_good_syncs = 1;
    TEST_ASSERT_TRUE(lin_table_commit(&error));
    expect_error("a power failure may restore the old one");
    expect_table("second");
    TEST_ASSERT_EQUAL_UINT32(0, lin_table_staged().size);
    TEST_ASSERT_FALSE(lin_table_commit(&error)); // nothing is left to be done
}
