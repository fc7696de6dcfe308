// SPDX-License-Identifier: Apache-2.0
/// stm_flash: erases and programs the sectors without code: 2 .. 7 of bank 1 and all of bank 2.
///
/// A sector has 128 KiB, a flash word 32 bytes; a word can be programmed once after an erase. Reads
/// of a bank stall while it is erased, so no tick may read it then. All functions: slow side, while
/// the tick runs. Source: RM0433 4.3.9 (program), 4.3.10 (erase), 4.3.12 (error correction), 4.9
/// (registers).
#ifndef STM_FLASH_H
#define STM_FLASH_H

#include <stdbool.h> // bool
#include <stdint.h>  // uint32_t

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

#endif
