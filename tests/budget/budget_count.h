// SPDX-License-Identifier: Apache-2.0
/// budget_count: exact instruction counts by the SysTick of an emulated core.
///
/// The emulator runs with -icount shift=8: an instruction takes 256 ns of virtual time, the counter
/// 40 ns, so 6.4 counts are one instruction and every single one is seen.
#ifndef BUDGET_COUNT_H
#define BUDGET_COUNT_H

#include <stdint.h> // uint32_t

#define BUDGET_SYSTICK ((volatile uint32_t *)0xE000E010u)

/// Start the counter: processor clock, no interrupt, 24 bits.
static inline void budget_count_start(void)
{
    BUDGET_SYSTICK[1] = 0xFFFFFFu;
    BUDGET_SYSTICK[2] = 0u;
    BUDGET_SYSTICK[0] = 5u;
}

/// @return the counter, falling
static inline uint32_t budget_count(void)
{
    return BUDGET_SYSTICK[2];
}

/// @return instructions between two readings, those of one reading included
static inline uint32_t budget_instructions(uint32_t from, uint32_t to)
{
    return (((from - to) & 0xFFFFFFu) * 10u + 32u) / 64u;
}

#endif
