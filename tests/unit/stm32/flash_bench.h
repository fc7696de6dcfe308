// SPDX-License-Identifier: Apache-2.0
/// flash_bench: flash sectors in memory with 32-bit addresses. The supply can fail in any erase or
/// write. A program defines flash_n_sectors and FLASH_PLACE, the name of
/// the first byte, and includes this once.
#ifndef FLASH_BENCH_H
#define FLASH_BENCH_H

#include "hal/hal.h"    // bool, uint32_t
#include "stm_memory.h" // stm_flash_erase
#include <setjmp.h>     // setjmp
#include <string.h>     // memcpy

enum {
    flash_bytes = flash_n_sectors * stm_flash_sector_bytes,
    flash_n_words = flash_bytes / stm_flash_word_bytes
};

/// What a word reads after its programming was interrupted; torn_not: it was complete.
typedef enum { torn_as_erased, torn_as_half, torn_unreadable, torn_not, n_torn } torn_t;

typedef struct {
    uint8_t bytes[flash_bytes];
    bool is_used[flash_n_words];       ///< cannot be programmed again
    bool is_unreadable[flash_n_words]; ///< a load would be a bus fault
} flash_t;

_Alignas(stm_flash_word_bytes) __attribute__((used)) uint8_t FLASH_PLACE[flash_bytes];

static flash_t flash; ///< except its bytes, which are at FLASH_PLACE
static int n_left;    ///< operations until the supply falls in the last of them, 0: it stays
static torn_t torn;
static jmp_buf supply_falls;

static uint32_t word_of(uint32_t address)
{
    return (address - (uint32_t)(uintptr_t)FLASH_PLACE) / stm_flash_word_bytes;
}

static bool is_cut(void)
{
    n_left--;
    return n_left == 0;
}

bool stm_flash_peek(uint32_t address, uint32_t *words)
{
    memcpy(words, (const void *)(uintptr_t)address, stm_flash_word_bytes);
    return !flash.is_unreadable[word_of(address)];
}

/// Sector after sector; words on the way to being erased are still to be erased.
bool stm_flash_erase(uint32_t address, uint32_t bytes)
{
    for (uint32_t at = 0; at < bytes; at += stm_flash_sector_bytes) {
        const uint32_t first = word_of(address + at);
        const bool ends_early = is_cut();
        const size_t n = stm_flash_sector_bytes / stm_flash_word_bytes / (ends_early ? 2u : 1u);
        memset((void *)(uintptr_t)(address + at), 0xFF, n * stm_flash_word_bytes);
        memset(&flash.is_used[first], ends_early ? 1 : 0, n);
        memset(&flash.is_unreadable[first], 0, n);
        if (ends_early) {
            longjmp(supply_falls, 1);
        }
    }
    return true;
}

bool stm_flash_program(uint32_t address, const uint8_t *bytes, uint32_t n)
{
    for (uint32_t at = 0; at < n; at += stm_flash_word_bytes) {
        const uint32_t i = word_of(address + at);
        const uint32_t n_here = n - at < stm_flash_word_bytes ? n - at : stm_flash_word_bytes;
        const uint32_t n_torn_bytes[n_torn] = {[torn_as_half] = n_here / 2u, [torn_not] = n_here};
        if (flash.is_used[i]) {
            return false;
        }
        flash.is_used[i] = true;
        const bool ends_early = is_cut();
        memcpy((void *)(uintptr_t)(address + at), bytes + at,
               ends_early ? n_torn_bytes[torn] : n_here);
        if (ends_early) {
            flash.is_unreadable[i] = torn == torn_unreadable;
            longjmp(supply_falls, 1);
        }
    }
    return true;
}

/// All erased.
static void flash_erase_all(void)
{
    memset(&flash, 0, sizeof flash);
    memset(FLASH_PLACE, 0xFF, flash_bytes);
}

static void flash_save(flash_t *saved)
{
    *saved = flash;
    memcpy(saved->bytes, FLASH_PLACE, flash_bytes);
}

static void flash_restore(const flash_t *saved)
{
    flash = *saved;
    memcpy(FLASH_PLACE, saved->bytes, flash_bytes);
}

#endif
