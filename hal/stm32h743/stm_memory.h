// SPDX-License-Identifier: Apache-2.0
/// stm_memory: memory protection unit and caches.
///
/// Regions, of which the one with the highest number counts:
///
///   - 0, 1: 60000000h .. 9FFFFFFFh, external: nothing; keeps the core from reading there by itself
///   - 2: flash, both banks: nothing. Its first sector holds the start-up and the images of the
///     memories, which nobody needs once the start-up has copied them
///   - 3, 8: flash with tables, all of bank 2 and bank 1 but its first sector: read, cached; while
///     the bank is erased or programmed read and written as a device, so that the core does not
///     read ahead and then wait for the end of the operation
///   - 4: ITCM: read, run; code cannot be overwritten
///   - 5: 0 .. FFFh: nothing; null pointers, and what lies behind one
///   - 6: DTCM: read, written; data cannot be run
///   - 7: the megabyte below the DTCM: nothing. The stack overflows into it and is caught; and it
///     holds the system memory, at 1FF00000h, where a fetch ahead of time would set RDSERR and
///     RDPERR in the flash interface although nobody asked for it (issue 60449 of Zephyr, seen on
///     revision V; Zephyr forbids it in the same way)
///   - 9: AXI SRAM: read, written; recorder and excitation, main() only
///   - 10: AXI SRAM, its first 128 KiB: read, run, cached; code that only main() runs
///
/// All other memory is as the architecture's default map says; peripherals are device memory. Only
/// the tables are read through the data cache. Only the core writes memory, as there is no DMA, and
/// the cache is invalidated after flash has been programmed.
#ifndef STM_MEMORY_H
#define STM_MEMORY_H

#include <stdbool.h> // bool
#include <stdint.h>  // uint64_t

/// The recorder's part of the AXI SRAM, from its first word to behind its last.
extern uint64_t stm_scope_start[], stm_scope_end[];

/// Protect memory, then invalidate and enable both caches. Context: before main(), from ITCM: the
/// start-up in flash cannot be returned to.
/// Source: ARMv7-M ARM B3.5 (regions), B2.2.7 (cache maintenance).
void stm_memory_init(void);

/// Open the tables of a bank for erase and programming, or protect them again.
/// @param bank  0 (bank 1) or 1 (bank 2)
/// Context: slow side, while no tick reads tables of this bank.
void stm_memory_open_tables(uint32_t bank, bool is_open);

#endif
