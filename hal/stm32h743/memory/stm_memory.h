// SPDX-License-Identifier: Apache-2.0
/// stm_memory: memory protection unit and caches.
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

#include <stdbool.h> // bool
#include <stdint.h>  // uint64_t

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

#endif
