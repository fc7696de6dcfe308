// SPDX-License-Identifier: Apache-2.0
/// stm_keep: why the processor started, and the text that hal_halt() left behind.
///
/// The text lies in memory that start-up does not touch, and is sealed by a check word. It is read
/// after a software reset only, because after a power-on the memory holds nothing that its error
/// correction would accept.
#ifndef STM_KEEP_H
#define STM_KEEP_H

#include "hal/hal.h" // hal_start_t

/// Keep the first 120 characters of a text for stm_keep_start().
/// Context: any, interrupts off.
void stm_keep_text(const char *why);

/// Read and clear the reset flags and the kept text.
/// @return the reason of the start, with the kept text
/// Context: slow side, once, at the begin of hal_init().
/// Source: RM0433 8.4 (reset sources, table of RCC_RSR), 8.7, RCC_RSR; chapter 3 (RAM ECC).
hal_start_t stm_keep_start(void);

#endif
