// SPDX-License-Identifier: Apache-2.0
/// stm_memory: the memories: protection and caches, error correction, flash, and what is kept in
/// it.
///
/// Where regions overlap, the one with the highest number applies:
///
///   - 0, 1: 60000000h .. 9FFFFFFFh, external: no access, to prevent speculative reads
///   - 2: flash, both banks: no access. The first two sectors hold start-up and load images, which
///     are not needed after start-up has copied them
///   - 3, 8: flash with tables, bank 2 and bank 1 except its first two sectors: read, cached; while
///     the bank is erased or programmed: read and write as device memory, so that the core does not
///     read ahead and then wait for the end of the operation
///   - 4: ITCM: read, execute; code cannot be overwritten
///   - 5: 0 .. FFFh: no access, to catch null pointers
///   - 6: DTCM: read, write; data cannot be executed
///   - 7: the megabyte below the DTCM: no access. It catches a stack overflow; and it holds the
///     system memory, at 1FF00000h, where a speculative fetch would set RDSERR and RDPERR in the
///     flash interface (Zephyr issue 60449, seen on revision V; Zephyr forbids it in the same way)
///   - 9: AXI SRAM: read, write; recorder and excitation, main() only
///   - 10: AXI SRAM, its first 128 KiB: read, execute, cached; code that only main() runs
///
/// All other memory follows the architecture's default map; peripherals are device memory. Only the
/// tables are read through the data cache. Without DMA, only the core writes memory; the cache is
/// invalidated after flash has been programmed.
#ifndef STM_MEMORY_H
#define STM_MEMORY_H

#include "hal/hal.h" // hal_start_t
#include "stm_reg.h" // RCC_RSR
#include <stdbool.h> // bool
#include <stdint.h>  // uint64_t, uint32_t

/// The recorder's part of the AXI SRAM: its first word, and the word after its last.
extern uint64_t stm_scope_start[], stm_scope_end[];

/// Protect memory, then invalidate and enable both caches. Context: before main(), from ITCM,
/// because the start-up in flash is no longer accessible afterwards.
/// Source: ARMv7-M ARM B3.5 (regions), B2.2.7 (cache maintenance).
void stm_memory_init(void);

/// Make the tables of a bank writable for erase and programming, or protect them again.
/// @param bank  0 (bank 1) or 1 (bank 2)
/// Context: slow side, while no tick reads tables of this bank.
void stm_memory_open_tables(uint32_t bank, bool is_open);

// Counts memory errors corrected by hardware and halts on uncorrectable ones. Flash and every RAM
// have an error-correction code: a single flipped bit in a word is corrected, two are detected.
// Start-up first writes all RAM in use (stm_start.c), because the code is random after power-on.
// Source: RM0433 chapter 3 (RAMECC), 4.3.12 (flash).

/// Enable the monitors of ITCM, DTCM and AXI SRAM, and the interrupt of double errors.
/// Context: slow side, once, after stm_keep_start().
void stm_ecc_init(void);

/// Handler of the double errors of RAM: halt with the address. Context: ISR.
void stm_ecc_isr(void);

/// A double error of flash raises a bus fault, and so may one of RAM.
/// @param exception  reason of a halt without a double error
/// @return           text with the address of a double error, else `exception`; static
/// Context: any, before a halt.
const char *stm_ecc_why(const char *exception);

/// Count corrected errors. A cell that stays flipped counts once, until its memory shows an error
/// at another address. Context: slow side.
void stm_ecc_poll(void);

/// @return number of corrected errors since the start. Context: slow side.
uint32_t stm_ecc_corrected(void);

// Erases and programs the sectors without code: 2 .. 7 of bank 1 and all of bank 2.
//
// A sector has 128 KiB, a flash word 32 bytes; a word can be programmed once after an erase. Reads
// of a bank stall while it is erased, so no tick may read it then. All functions: slow side, while
// the tick runs. Source: RM0433 4.3.9 (program), 4.3.10 (erase), 4.3.12 (error correction), 4.9
// (registers).

enum { stm_flash_sector_bytes = 1 << 17, stm_flash_word_bytes = 32, stm_flash_words = 8 };

/// Erase sectors.
/// @param address  of the first sector
/// @param bytes    [bytes] to be erased, rounded up to whole sectors
/// @return         false when an erase does not end, or ends with an error
/// Context: 1 to 4 s for each sector. hal_idle() is called meanwhile, so the watchdog continues to
/// supervise the tick.
bool stm_flash_erase(uint32_t address, uint32_t bytes);

/// Program bytes and verify them.
/// @param address  of a flash word
/// @param n        [bytes]; the rest of the last flash word becomes FFh
/// @return         false when programming fails, or the bytes cannot be read back as written
bool stm_flash_program(uint32_t address, const uint8_t *bytes, uint32_t n);

/// Read a flash word whose programming or erase a loss of power may have interrupted.
/// @param words  result, stm_flash_words of them
/// @return       false when it has an uncorrectable error, where a plain load would be a bus fault
bool stm_flash_peek(uint32_t address, uint32_t *words);

/// Find how much of a place is readable after an interrupted download or programmer.
/// @param address  of a flash word
/// @param bytes    [bytes] of the place
/// @return         [bytes] `bytes`, or less: the next 256 bytes then hold a flash word with an
///                 uncorrectable error, where a plain load would be a bus fault
/// Context: slow side; about 3 ms for a megabyte, with interrupts held back for less than 1 us.
uint32_t stm_flash_readable(uint32_t address, uint32_t bytes);

// Two places for tables in flash, and a log that records which one is in use.

/// Read the log. Context: slow side, once, before hal_table_image().
void stm_table_init(void);

/// @return whether the table in use is lost: older firmware stored it where code is now.
/// Context: slow side.
bool stm_table_is_lost(void);

// Flash log that keeps parameters across a restart (hal_params_*()).

/// Find the current record. Context: slow side, once, before hal_params_kept().
void stm_params_init(void);

// Reason for the last start, and the text of the last hal_halt().
//
// The text has a check word. Start-up clears its memory, whose error-correction code is random
// after power-on, except after a software reset.

/// @return whether, according to RCC_RSR, memory has kept its content since the last start. Always
/// inlined, because start-up in flash calls it before code has been copied to RAM.
__attribute__((always_inline)) static inline bool stm_keep_may_hold(uint32_t flags)
{
    return (flags & (RCC_RSR_SFTRSTF | RCC_RSR_PORRSTF | RCC_RSR_BORRSTF)) == RCC_RSR_SFTRSTF;
}

/// Keep the first 120 characters of a text for stm_keep_start().
/// Context: any, interrupts off.
void stm_keep_text(const char *why);

/// Read and clear the reset flags and the kept text.
/// @return the reason of the start, with the kept text
/// Context: slow side, once, at the start of hal_init().
/// Source: RM0433 8.4 (reset sources, table of RCC_RSR), 8.7, RCC_RSR; chapter 3 (RAM ECC).
hal_start_t stm_keep_start(void);

#endif
