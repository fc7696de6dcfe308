// SPDX-License-Identifier: Apache-2.0
// The file of the black box: kept, found again, forgotten, and what else may lie there.
#include "lin_setup.h"
#include "lin_disk_bench.h"

static char file[120];

void setUp(void)
{
    (void)snprintf(file, sizeof file, "%s.blackbox", path);
    (void)unlink(file);
    lin_blackbox_open(path, &error);
}

static void test_words_that_are_kept_are_at_the_begin_after_a_restart(void)
{
    TEST_ASSERT_EQUAL_STRING("", error.text); // no file is nothing wrong
    TEST_ASSERT_EQUAL_UINT32(0, lin_blackbox_memory().n_kept);
    TEST_ASSERT_EQUAL_UINT32(lin_blackbox_words, lin_blackbox_memory().n_words);
    int32_t *words = lin_blackbox_memory().words;
    for (int32_t i = 0; i < 3000; i++) {
        words[1000 + i] = 7 * i - 9;
    }
    lin_blackbox_keep(&words[1000], 3000, &error);
    TEST_ASSERT_EQUAL_STRING("", error.text);
    memset(words, 0, 5000 * sizeof *words);
    lin_blackbox_open(path, &error);
    TEST_ASSERT_EQUAL_STRING("", error.text);
    TEST_ASSERT_EQUAL_UINT32(3000, lin_blackbox_memory().n_kept);
    for (int32_t i = 0; i < 3000; i++) {
        TEST_ASSERT_EQUAL_INT32(7 * i - 9, words[i]);
    }
}

static void test_what_is_forgotten_is_not_found_again(void)
{
    lin_blackbox_keep(lin_blackbox_memory().words, 10, &error);
    lin_blackbox_keep(lin_blackbox_memory().words, 0, &error);
    TEST_ASSERT_EQUAL_STRING("", error.text);
    lin_blackbox_keep(lin_blackbox_memory().words, 0, &error); // again: nothing is there
    TEST_ASSERT_EQUAL_STRING("", error.text);
    TEST_ASSERT_NOT_EQUAL(0, access(file, F_OK));
}

static void test_a_file_of_another_kind_is_reported_and_not_used(void)
{
    static const long sizes[] = {1, 4093, 4L * lin_blackbox_words + 4};
    for (uint32_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        put_file(file, "");
        TEST_ASSERT_EQUAL_INT(0, truncate(file, sizes[i]));
        lin_blackbox_open(path, &error);
        expect_error("not a black box; remove it");
        TEST_ASSERT_EQUAL_UINT32(0, lin_blackbox_memory().n_kept);
    }
}

static void test_a_folder_that_is_gone_is_reported(void)
{
    TEST_ASSERT_EQUAL_INT(0, rmdir(folder));
    lin_blackbox_keep(lin_blackbox_memory().words, 10, &error);
    expect_error(file);
    TEST_ASSERT_EQUAL_INT(0, mkdir(folder, 0700));
}
