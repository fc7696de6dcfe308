// SPDX-License-Identifier: Apache-2.0
/// stm_keep: reason for the last start, and the text of the last hal_halt().
///
/// The text has a check word. Start-up clears its memory, whose error-correction code is random
/// after power-on, except after a software reset.
#ifndef STM_KEEP_H
#define STM_KEEP_H

#include "hal/hal.h" // hal_start_t
#include "stm_reg.h" // RCC_RSR
#include <stdbool.h> // bool

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
