// SPDX-License-Identifier: Apache-2.0
// The log of the parameters in flash: the supply falls in every write and in every erase, and what
// is torn reads as erased, as anything, or not at all.
#include "unity.h"

enum { flash_n_sectors = 2, record_bytes = 900, record_ops = (record_bytes + 31) / 32 + 1 };
#define FLASH_PLACE stm_params_start
#include "flash_bench.h"

void setUp(void)
{
    flash_erase_all();
    n_left = 0;
    stm_params_init();
}

static uint8_t record[hal_params_most_bytes];

static bool keep(uint8_t version, uint32_t n)
{
    memset(record, version, n);
    return hal_params_keep(record, n);
}

/// Now and after a restart.
static void expect_kept(uint8_t version, uint32_t n)
{
    for (int i = 0; i < 2; i++) {
        const hal_params_t kept = hal_params_kept();
        TEST_ASSERT_EQUAL_UINT32(n, kept.size);
        TEST_ASSERT_EACH_EQUAL_HEX8(version, kept.bytes, n);
        stm_params_init();
    }
}

/// Keep until the supply falls, then start anew.
static void keep_until_dark(uint8_t version, int op)
{
    if (setjmp(supply_falls) == 0) {
        n_left = op;
        (void)keep(version, record_bytes);
    }
    n_left = 0;
    stm_params_init();
}

/// Cut the next save at each of its operations, once and twice in turn; the old record stays, and
/// the next save is whole.
static void cut_everywhere(uint8_t old, int n_ops)
{
    static flash_t before;
    flash_save(&before);
    for (int op = 1; op <= n_ops; op++) {
        flash_restore(&before);
        stm_params_init();
        for (int i = 0; i < 2; i++) {
            keep_until_dark((uint8_t)(old + 1), op);
            expect_kept(old, record_bytes);
        }
        bool is_kept = keep((uint8_t)(old + 1), record_bytes);
        if (!is_kept) { // a word that was torn reads as erased, and fails
            is_kept = keep((uint8_t)(old + 1), record_bytes);
        }
        TEST_ASSERT_TRUE(is_kept);
        expect_kept((uint8_t)(old + 1), record_bytes);
    }
}

static void test_keep_first_record_is_found_by_the_next_start(void)
{
    TEST_ASSERT_EQUAL_UINT32(0, hal_params_kept().size);
    TEST_ASSERT_FALSE(hal_params_kept().is_damaged);
    TEST_ASSERT_FALSE(keep(1, 0));
    TEST_ASSERT_FALSE(hal_params_keep(record, hal_params_most_bytes + 1));
    TEST_ASSERT_TRUE(keep(1, hal_params_most_bytes));
    expect_kept(1, hal_params_most_bytes);
    TEST_ASSERT_FALSE(hal_params_kept().is_damaged);
}

/// Far beyond what both sectors hold: the newest is always there, also after a restart.
static void test_keep_many_times_goes_round_both_sectors(void)
{
    for (uint32_t i = 1; i < 60u; i++) {
        const uint32_t n = i % 3u == 0u ? 1u : hal_params_most_bytes - i;
        TEST_ASSERT_TRUE(keep((uint8_t)i, n));
        expect_kept((uint8_t)i, n);
        TEST_ASSERT_FALSE(hal_params_kept().is_damaged);
    }
}

/// Fill a sector but for less than a record, and the one before it whole where it is the second.
static void fill(uint32_t sector)
{
    const size_t end = (size_t)(sector + 1u) * stm_flash_sector_bytes;
    size_t used = 0;
    while (used + (size_t)2 * record_ops * stm_flash_word_bytes <= end) {
        TEST_ASSERT_TRUE(keep(3, record_bytes));
        used = (size_t)((const uint8_t *)hal_params_kept().bytes - stm_params_start);
    }
}

/// Of an append, and of a compaction: the open sector is full, so the other one is erased, which
/// may hold records of before.
static void test_power_lost_at_any_operation_leaves_the_old_record(void)
{
    for (torn = torn_as_erased; torn < torn_not; torn++) {
        setUp();
        TEST_ASSERT_TRUE(keep(1, record_bytes));
        TEST_ASSERT_TRUE(keep(2, record_bytes));
        cut_everywhere(2, record_ops);
        for (uint32_t sector = 0; sector < 2u; sector++) {
            setUp();
            fill(sector);
            cut_everywhere(3, record_ops + 1);
        }
    }
}

/// Before the first record nothing is known of the sectors, so one is erased.
static void test_power_lost_at_any_operation_of_the_first_save_leaves_none(void)
{
    for (torn = torn_as_erased; torn < torn_not; torn++) {
        for (int op = 1; op <= record_ops + 1; op++) {
            setUp();
            keep_until_dark(1, op);
            TEST_ASSERT_EQUAL_UINT32(0, hal_params_kept().size);
            TEST_ASSERT_TRUE(keep(2, record_bytes));
            expect_kept(2, record_bytes);
        }
    }
}

/// A word of the newest record can no longer be read: the record before counts. Damage is reported
/// until the next record is kept.
static void test_a_record_that_cannot_be_read_does_not_count(void)
{
    torn = torn_as_half;
    TEST_ASSERT_TRUE(keep(1, record_bytes));
    keep_until_dark(2, 3);
    expect_kept(1, record_bytes);
    TEST_ASSERT_TRUE(hal_params_kept().is_damaged);
    TEST_ASSERT_TRUE(keep(2, record_bytes));
    TEST_ASSERT_FALSE(hal_params_kept().is_damaged);
    expect_kept(2, record_bytes);
    TEST_ASSERT_FALSE(hal_params_kept().is_damaged);
    setUp();
    TEST_ASSERT_TRUE(keep(1, record_bytes));
    TEST_ASSERT_TRUE(keep(2, record_bytes));
    flash.is_unreadable[record_ops + 4] = true;
    stm_params_init();
    expect_kept(1, record_bytes);
    TEST_ASSERT_TRUE(hal_params_kept().is_damaged);
    flash.is_unreadable[4] = true;
    stm_params_init();
    TEST_ASSERT_EQUAL_UINT32(0, hal_params_kept().size);
    TEST_ASSERT_TRUE(hal_params_kept().is_damaged);
}
