// SPDX-License-Identifier: Apache-2.0
#include "stm_memory.h"
#include "board_config.h"
#include <string.h> // memcmp

enum { flash_start = 0x08000000, bank_bytes = 1 << 20 };

/// Limits far above the longest times of the data sheet, 4 s for a sector and 0.5 ms for a flash
/// word. The wait for an erase calls hal_idle(), which returns at least once a tick.
enum { most_erase_waits = 10 * BOARD_TICK_HZ, most_program_loops = 1000000 };

/// @return the bank of an address, 0 or 1
static uint32_t bank_of(uint32_t address)
{
    return (address - flash_start) / bank_bytes;
}

/// Read error flags are ignored: RDSERR and RDPERR come from speculative reads (stm_memory.h,
/// region 7), and stm_ecc counts SNECCERR. Written data are read back and compared.
/// @return whether the operation has ended without an error; its flags are cleared
static bool ends_well(uint32_t bank)
{
    const uint32_t flags = FLASH_SR(bank);
    FLASH_CCR(bank) = flags & FLASH_SR_FLAGS;
    return (flags & (FLASH_SR_QW | FLASH_SR_ERRORS)) == 0u;
}

/// Make the tables of a bank writable and unlock its control register. If it is unlocked already,
/// the keys are not written, because they may then lock it until a reset. RM0433 4.5.1.
/// @return false when it stays locked
static bool open_bank(uint32_t bank)
{
    stm_memory_open_tables(bank, true);
    FLASH_CCR(bank) = FLASH_SR_FLAGS;
    if ((FLASH_CR(bank) & FLASH_CR_LOCK) != 0u) {
        FLASH_KEYR(bank) = FLASH_KEYR_FIRST;
        FLASH_KEYR(bank) = FLASH_KEYR_SECOND;
    }
    return (FLASH_CR(bank) & FLASH_CR_LOCK) == 0u;
}

/// Lock the control register of a bank and protect the tables again.
static void close_bank(uint32_t bank)
{
    FLASH_CR(bank) = FLASH_CR_LOCK;
    stm_memory_open_tables(bank, false);
}

/// Erase a sector of an open bank, while the main loop idles.
static bool erase_sector(uint32_t bank, uint32_t sector)
{
    const uint32_t what = FLASH_CR_SER | FLASH_CR_PSIZE_64 | FLASH_CR_SNB(sector);
    FLASH_CR(bank) = what;
    FLASH_CR(bank) = what | FLASH_CR_START;
    stm_barrier();
    for (uint32_t i = 0; i < most_erase_waits && (FLASH_SR(bank) & FLASH_SR_QW) != 0u; i++) {
        hal_idle();
    }
    return ends_well(bank);
}

bool stm_flash_erase(uint32_t address, uint32_t bytes)
{
    const uint32_t bank = bank_of(address);
    const uint32_t first = address % bank_bytes / stm_flash_sector_bytes;
    const uint32_t n = (bytes + stm_flash_sector_bytes - 1u) / stm_flash_sector_bytes;
    bool is_good = open_bank(bank);
    for (uint32_t i = 0; i < n && is_good; i++) {
        is_good = erase_sector(bank, first + i);
    }
    close_bank(bank);
    return is_good;
}

/// @return the four bytes at `at` as a word, padded with FFh beyond the n bytes
static uint32_t word_at(const uint8_t *bytes, uint32_t n, uint32_t at)
{
    uint32_t word = UINT32_MAX;
    for (uint32_t i = 0; i < 4u && at + i < n; i++) {
        word &= ~(0xFFu << 8u * i) | (uint32_t)bytes[at + i] << 8u * i;
    }
    return word;
}

/// Program a flash word of an open bank. The flash interface collects eight words and starts
/// programming after the last one.
static bool program_word(uint32_t bank, uint32_t address, const uint8_t *bytes, uint32_t n)
{
    volatile uint32_t *to = (volatile uint32_t *)address;
    for (uint32_t i = 0; i < stm_flash_words; i++) {
        to[i] = word_at(bytes, n, 4u * i);
    }
    stm_barrier();
    for (uint32_t i = 0; i < most_program_loops && (FLASH_SR(bank) & FLASH_SR_QW) != 0u; i++) {
    }
    return ends_well(bank);
}

bool stm_flash_program(uint32_t address, const uint8_t *bytes, uint32_t n)
{
    const uint32_t bank = bank_of(address);
    bool is_good = open_bank(bank);
    FLASH_CR(bank) = FLASH_CR_PG | FLASH_CR_PSIZE_64;
    // The bit must arrive before the first store, which uses another bus; otherwise PGSERR.
    // RM0433 4.3.9; embassy pull requests 1014 and 2539.
    stm_barrier();
    for (uint32_t at = 0; at < n && is_good; at += stm_flash_word_bytes) {
        is_good = program_word(bank, address + at, bytes + at, n - at);
    }
    close_bank(bank);
    return is_good && stm_flash_readable(address, n) >= n &&
           memcmp((const void *)address, bytes, n) == 0;
}

/// Suppress bus faults of loads by FAULTMASK and BFHFNMIGN; the flash interface still reports an
/// unreadable word in its status. Interrupts wait meanwhile.
static void begin_peeking(void)
{
    __asm volatile("cpsid f" ::: "memory");
    SCB_CCR |= SCB_CCR_BFHFNMIGN;
    stm_barrier();
}

static void end_peeking(void)
{
    stm_barrier();
    SCB_CCR &= ~SCB_CCR_BFHFNMIGN;
    __asm volatile("cpsie f" ::: "memory");
}

/// @return whether all reads since the flags were last cleared succeeded; clears the flags
static bool was_readable(uint32_t bank)
{
    const bool is_readable = (FLASH_SR(bank) & FLASH_SR_DBECCERR) == 0u;
    FLASH_CCR(bank) = FLASH_SR_FLAGS;
    return is_readable;
}

bool stm_flash_peek(uint32_t address, uint32_t *words)
{
    const volatile uint32_t *from = (const volatile uint32_t *)address;
    FLASH_CCR(bank_of(address)) = FLASH_SR_FLAGS;
    begin_peeking();
    for (uint32_t i = 0; i < stm_flash_words; i++) {
        words[i] = from[i];
    }
    end_peeking();
    return was_readable(bank_of(address));
}

uint32_t stm_flash_readable(uint32_t address, uint32_t bytes)
{
    enum { step = 8 * stm_flash_word_bytes }; // under a microsecond without interrupts
    FLASH_CCR(bank_of(address)) = FLASH_SR_FLAGS;
    for (uint32_t at = 0; at < bytes; at += step) {
        begin_peeking();
        for (uint32_t i = at; i < at + step && i < bytes; i += stm_flash_word_bytes) {
            (void)*(const volatile uint32_t *)(address + i);
        }
        end_peeking();
        if (!was_readable(bank_of(address))) {
            return at;
        }
    }
    return bytes;
}
