// SPDX-License-Identifier: Apache-2.0
/// stm_memory: protection unit and caches.
///
/// | region | memory | may be | why |
/// |---|---|---|---|
/// | 0, 1 | 60000000h .. 9FFFFFFFh, external | nothing | the core never looks there ahead of time |
/// | 2 | flash, both banks | read, run, cached | start-up, images of ITCM and DTCM |
/// | 3 | flash, bank 2 | read, cached | the table is data |
/// | 8 | flash, bank 1, all but its first sector | read, cached | so is the other one |
/// | 4 | ITCM | read, run | code cannot be overwritten |
/// | 5 | 0 .. FFh | nothing | null pointers |
/// | 6 | DTCM | read, written | data cannot be run |
/// | 7 | the 4 KiB below the DTCM | nothing | the stack's end |
///
/// The rest is as the architecture's default map says: peripherals are device memory. Only the
/// tables are read through the data cache. Nothing but the core writes memory: no DMA; what flash
/// programming changes is forgotten by the cache behind it.
#ifndef STM_MEMORY_H
#define STM_MEMORY_H

#include <stdbool.h> // bool

/// Protect memory, empty and enable both caches. Context: start-up, before main().
/// Source: ARMv7-M ARM B3.5 (regions), B2.2.7 (cache maintenance).
void stm_memory_init(void);

/// Let regions 3 and 8 be written, past the cache, or make them again what the table says.
/// Context: slow side, no tick reads them.
void stm_memory_open_tables(bool is_open);

#endif
