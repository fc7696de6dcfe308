// SPDX-License-Identifier: Apache-2.0
/// stm_memory: memory protection unit and caches.
///
/// | region | memory | may be | why |
/// |---|---|---|---|
/// | 0, 1 | 60000000h .. 9FFFFFFFh, external | nothing | keeps the core from reading there
/// speculatively | | 2 | flash, both banks | read, run, cached | holds start-up and the images of
/// ITCM and DTCM | | 3 | flash, bank 2 | read, cached | holds a table, which is data | | 8 | flash,
/// bank 1, all but its first sector | read, cached | holds the other table | | 4 | ITCM | read, run
/// | code cannot be overwritten | | 5 | 0 .. FFh | nothing | null pointers | | 6 | DTCM | read,
/// written | data cannot be run | | 7 | the 4 KiB below the DTCM | nothing | the stack overflows
/// into it and is caught | | 9 | AXI SRAM | read, written | recorder and excitation, main() only |
/// | 10 | AXI SRAM, its first 128 KiB | read, run, cached | code that only main() runs |
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

/// Protect memory, then invalidate and enable both caches. Context: start-up, before main().
/// Source: ARMv7-M ARM B3.5 (regions), B2.2.7 (cache maintenance).
void stm_memory_init(void);

/// Make regions 3 and 8 writable and uncached, or what the table says again.
/// Context: slow side, while no tick reads them.
void stm_memory_open_tables(bool is_open);

#endif
