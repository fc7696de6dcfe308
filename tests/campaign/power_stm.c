// SPDX-License-Identifier: Apache-2.0
// The supply of the STM32 port falls in every write and every erase of a download, and of the log
// that records which table is in use. stm_table.c is linked with a flash memory of this program,
// whose addresses fit 32 bits. After each fall the next start must find the old table or the new
// one.
//
// Prints one JSON object; exits 1 where a start finds something else.
#include <stdio.h> // printf

enum { flash_n_sectors = 3 }; ///< place 0, place 1 and the log, as CMakeLists.txt has the symbols
#define FLASH_PLACE campaign_flash
#include "flash_bench.h"

enum { table_bytes = 6 * 1024, piece = 1024, full_log_words = 512 };
enum { log_word = 2 * stm_flash_sector_bytes / stm_flash_word_bytes };

static flash_t saved;
static uint32_t n_idles;
static struct {
    unsigned n, n_old, n_new, n_wrong, n_again_failed;
} sum;

uint32_t stm_flash_readable(uint32_t address, uint32_t bytes)
{
    uint32_t at = 0;
    while (at < bytes && !flash.is_unreadable[word_of(address + at)]) {
        at += stm_flash_word_bytes;
    }
    return at < bytes ? at : bytes;
}

/// Feeds the watchdog: between the checks of a table before and after its record is written, since
/// two of them may take longer than a second.
void hal_idle(void)
{
    n_idles++;
}

/// @return whether every step of a download of a table of this byte succeeded
static bool download(uint8_t version)
{
    uint8_t bytes[piece];
    memset(bytes, version, sizeof bytes);
    bool is_good = hal_table_begin(table_bytes);
    for (uint32_t at = 0; at < (uint32_t)table_bytes && is_good; at += piece) {
        is_good = hal_table_write(at, bytes, piece);
    }
    const uint32_t n_before = n_idles;
    return is_good && hal_table_commit() && n_idles > n_before;
}

/// @return whether the table in use is whole and of this byte
static bool is_in_use(uint8_t version)
{
    const hal_image_t image = hal_table_image();
    bool is_whole = image.size >= (uint32_t)table_bytes;
    for (uint32_t i = 0; i < (uint32_t)table_bytes && is_whole; i++) {
        is_whole = ((const uint8_t *)image.bytes)[i] == version;
    }
    return is_whole;
}

/// The next start finds the old table or the new one.
static void count_start(uint8_t old)
{
    stm_table_init();
    const bool is_old = is_in_use(old);
    const bool is_new = !is_old && is_in_use((uint8_t)(old + 1u));
    sum.n++;
    sum.n_old += is_old ? 1u : 0u;
    sum.n_new += is_new ? 1u : 0u;
    sum.n_wrong += is_old || is_new ? 0u : 1u;
}

/// @return whether the supply fell
static bool download_until_dark(uint8_t version, int op)
{
    n_left = op;
    volatile bool fell = true;
    if (setjmp(supply_falls) == 0) {
        (void)download(version);
        fell = false;
    }
    n_left = 0;
    return fell;
}

/// Cut the next download at each of its operations, and once more at the same one; then it must go
/// through, at the second try where a torn word looks erased.
static void cut_everywhere(uint8_t old)
{
    flash_save(&saved);
    for (int op = 1;; op++) {
        flash_restore(&saved);
        stm_table_init();
        if (!download_until_dark((uint8_t)(old + 1u), op)) {
            return;
        }
        count_start(old);
        if (download_until_dark((uint8_t)(old + 1u), op)) {
            count_start(old);
        }
        const bool is_through = download((uint8_t)(old + 1u)) || download((uint8_t)(old + 1u));
        stm_table_init();
        sum.n_again_failed += is_through && is_in_use((uint8_t)(old + 1u)) ? 0u : 1u;
    }
}

static void begin(void)
{
    flash_erase_all();
    stm_table_init();
    memset(campaign_flash, 1, table_bytes); // by a programming tool
}

int main(void)
{
    for (torn = torn_as_erased; torn < n_torn; torn++) {
        begin();
        cut_everywhere(1); // place 0 is in use by the empty log
        begin();
        (void)download(2);
        stm_table_init();
        cut_everywhere(2); // place 1 is in use
        begin();
        uint8_t version = 1;
        while (!flash.is_used[log_word + full_log_words]) {
            version = version < 250u ? (uint8_t)(version + 1u) : 2u;
            (void)download(version);
        }
        stm_table_init();
        cut_everywhere(version); // the log is to be erased, or will be with the next but one
        (void)download((uint8_t)(version + 1u));
        stm_table_init();
        cut_everywhere((uint8_t)(version + 1u));
    }
    (void)printf("{\"falls\": %u, \"old\": %u, \"new\": %u, \"wrong\": %u, \"not_again\": %u}\n",
                 sum.n, sum.n_old, sum.n_new, sum.n_wrong, sum.n_again_failed);
    return sum.n_wrong > 0u || sum.n_again_failed > 0u || sum.n == 0u ? 1 : 0;
}
