// SPDX-License-Identifier: Apache-2.0
/// stm_flash: erases and programs the sectors that hold no code: 1 .. 7 of bank 1, all of bank 2.
///
/// A sector is 128 KiB, a flash word 32 bytes, programmed once behind an erase. Reading a bank
/// waits while it is erased: no tick may do it. All functions: slow side, the tick runs. Source:
/// RM0433 4.3.9 (program), 4.3.10 (erase), 4.3.12 (error correction), 4.9 (registers).
#ifndef STM_FLASH_H
#define STM_FLASH_H

#include <stdbool.h> // bool
#include <stdint.h>  // uint32_t

enum { stm_flash_sector_bytes = 1 << 17, stm_flash_word_bytes = 32, stm_flash_words = 8 };

/// Erase sectors from an address on. @return false when one does not end, or ends with an error
/// Context: 1 to 4 s for each; hal_idle() is called meanwhile, so the watchdog watches the tick.
bool stm_flash_erase(uint32_t address, uint32_t bytes);

/// Program and compare. @return false when it does not read as it should
/// @param address  of a flash word
/// @param n        [bytes] the rest of the last flash word becomes FFh
bool stm_flash_program(uint32_t address, const uint8_t *bytes, uint32_t n);

/// Read a flash word whose programming or erase may have been cut off.
/// @param words  [stm_flash_words]
/// @return       false: beyond correction; a plain load would be a bus fault
bool stm_flash_peek(uint32_t address, uint32_t *words);

#endif
