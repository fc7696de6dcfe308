// SPDX-License-Identifier: Apache-2.0
// The supply of the STM32 port falls in every write and every erase of a download, and of the log
// that records which table is in use. stm_table.c is linked with a flash memory of this program,
// whose addresses fit 32 bits. After each fall the next start must find the old table or the new
// one.
//
// Prints one JSON object; exits 1 where a start finds something else.
#include "hal/hal.h"
#include "stm_memory.h"
#include <setjmp.h> // setjmp
#include <stdio.h>  // printf
#include <string.h> // memset

enum { n_sectors = 3, sector = stm_flash_sector_bytes };
enum { table_bytes = 6 * 1024, piece = 1024, n_words = n_sectors * sector / stm_flash_word_bytes };
enum { log_word = 2 * sector / stm_flash_word_bytes, full_log_words = 512 };

/// What a word reads as whose programming was cut off.
typedef enum { torn_as_erased, torn_as_half, torn_unreadable, torn_not, n_torn } torn_t;
typedef enum { found_old, found_new, found_wrong } found_t;

/// Place 0, place 1 and the log, where CMakeLists.txt lets the symbols of the linker script point.
_Alignas(stm_flash_word_bytes) __attribute__((used)) uint8_t campaign_flash[n_sectors * sector];

static struct {
    uint8_t bytes[n_sectors * sector];
    bool is_used[n_words], is_unreadable[n_words];
} saved;
static bool is_used[n_words], is_unreadable[n_words];
static int n_left; // operations until the supply falls in the last of them, 0: it stays
static uint32_t n_idles;
static torn_t torn;
static jmp_buf supply_falls;
static struct {
    unsigned n, n_old, n_new, n_wrong, n_again_failed;
} sum;

static uint32_t word_of(uint32_t address)
{
    return (address - (uint32_t)(uintptr_t)campaign_flash) / stm_flash_word_bytes;
}

static bool is_cut(void)
{
    n_left--;
    return n_left == 0;
}

bool stm_flash_peek(uint32_t address, uint32_t *words)
{
    memcpy(words, (const void *)(uintptr_t)address, stm_flash_word_bytes);
    return !is_unreadable[word_of(address)];
}

uint32_t stm_flash_readable(uint32_t address, uint32_t bytes)
{
    uint32_t at = 0;
    while (at < bytes && !is_unreadable[word_of(address + at)]) {
        at += stm_flash_word_bytes;
    }
    return at < bytes ? at : bytes;
}

bool stm_flash_erase(uint32_t address, uint32_t bytes)
{
    for (uint32_t at = 0; at < bytes; at += sector) { // sector after sector
        const uint32_t first = word_of(address + at);
        const bool ends_early = is_cut();
        const size_t n = sector / stm_flash_word_bytes / (ends_early ? 2u : 1u);
        memset((void *)(uintptr_t)(address + at), 0xFF, n * stm_flash_word_bytes);
        memset(&is_used[first], ends_early ? 1 : 0, n);
        memset(&is_unreadable[first], 0, n);
        if (ends_early) {
            longjmp(supply_falls, 1);
        }
    }
    return true;
}

static void tear(uint32_t i, const uint8_t *bytes)
{
    is_unreadable[i] = torn == torn_unreadable;
    if (torn == torn_not) { // the last instant before the supply falls
        memcpy(&campaign_flash[i * stm_flash_word_bytes], bytes, stm_flash_word_bytes);
    }
    if (torn == torn_as_half) {
        memcpy(&campaign_flash[i * stm_flash_word_bytes], bytes, stm_flash_word_bytes / 2u);
    }
    longjmp(supply_falls, 1);
}

/// Feeds the watchdog: between the checks of a table before and after its record is written, since
/// two of them may take longer than a second.
void hal_idle(void)
{
    n_idles++;
}

bool stm_flash_program(uint32_t address, const uint8_t *bytes, uint32_t n)
{
    for (uint32_t at = 0; at < n; at += stm_flash_word_bytes) {
        const uint32_t i = word_of(address + at);
        if (is_used[i]) {
            return false;
        }
        is_used[i] = true;
        if (is_cut()) {
            tear(i, bytes + at);
        }
        memcpy((void *)(uintptr_t)(address + at), bytes + at, stm_flash_word_bytes);
    }
    return true;
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

static found_t found(uint8_t old)
{
    return is_in_use(old) ? found_old : is_in_use((uint8_t)(old + 1u)) ? found_new : found_wrong;
}

static void save(void)
{
    memcpy(saved.bytes, campaign_flash, sizeof campaign_flash);
    memcpy(saved.is_used, is_used, sizeof is_used);
    memcpy(saved.is_unreadable, is_unreadable, sizeof is_unreadable);
}

static void restore(void)
{
    memcpy(campaign_flash, saved.bytes, sizeof campaign_flash);
    memcpy(is_used, saved.is_used, sizeof is_used);
    memcpy(is_unreadable, saved.is_unreadable, sizeof is_unreadable);
    stm_table_init();
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
    save();
    for (int op = 1;; op++) {
        restore();
        if (!download_until_dark((uint8_t)(old + 1u), op)) {
            return;
        }
        stm_table_init();
        const found_t first = found(old);
        sum.n++;
        sum.n_old += first == found_old ? 1u : 0u;
        sum.n_new += first == found_new ? 1u : 0u;
        sum.n_wrong += first == found_wrong ? 1u : 0u;
        if (download_until_dark((uint8_t)(old + 1u), op)) {
            stm_table_init();
            sum.n++;
            const found_t second = found(old);
            sum.n_old += second == found_old ? 1u : 0u;
            sum.n_new += second == found_new ? 1u : 0u;
            sum.n_wrong += second == found_wrong ? 1u : 0u;
        }
        const bool is_through = download((uint8_t)(old + 1u)) || download((uint8_t)(old + 1u));
        stm_table_init();
        sum.n_again_failed += is_through && is_in_use((uint8_t)(old + 1u)) ? 0u : 1u;
    }
}

static void begin(void)
{
    memset(campaign_flash, 0xFF, sizeof campaign_flash);
    memset(is_used, 0, sizeof is_used);
    memset(is_unreadable, 0, sizeof is_unreadable);
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
        while (!is_used[log_word + full_log_words]) {
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
