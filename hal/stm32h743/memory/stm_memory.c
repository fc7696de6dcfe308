// SPDX-License-Identifier: Apache-2.0
#include "stm_memory.h"
#include <stddef.h> // size_t

/// A region of the protection unit.
typedef struct {
    uint32_t base;       ///< a multiple of its size
    uint32_t attributes; ///< of MPU_RASR
} region_t;

/// In the order of their numbers; stm_memory.h lists their purposes.
static const region_t regions[] = {
    {0x60000000u, MPU_RASR_SIZE(29) | MPU_RASR_NO_ACCESS | MPU_RASR_XN},
    {0x80000000u, MPU_RASR_SIZE(29) | MPU_RASR_NO_ACCESS | MPU_RASR_XN},
    {0x08000000u, MPU_RASR_SIZE(21) | MPU_RASR_NO_ACCESS | MPU_RASR_XN},
    {0x08100000u, MPU_RASR_SIZE(20) | MPU_RASR_READ_ONLY | MPU_RASR_WRITE_THROUGH | MPU_RASR_XN},
    {0x00000000u, MPU_RASR_SIZE(16) | MPU_RASR_READ_ONLY | MPU_RASR_UNCACHED},
    {0x00000000u, MPU_RASR_SIZE(12) | MPU_RASR_NO_ACCESS | MPU_RASR_XN},
    {0x20000000u, MPU_RASR_SIZE(17) | MPU_RASR_READ_WRITE | MPU_RASR_UNCACHED | MPU_RASR_XN},
    {0x1FF00000u, MPU_RASR_SIZE(20) | MPU_RASR_NO_ACCESS | MPU_RASR_XN},
    {0x08000000u, MPU_RASR_SIZE(20) | MPU_RASR_WITHOUT(0) | MPU_RASR_WITHOUT(1) |
                      MPU_RASR_READ_ONLY | MPU_RASR_WRITE_THROUGH | MPU_RASR_XN},
    {0x24000000u, MPU_RASR_SIZE(19) | MPU_RASR_READ_WRITE | MPU_RASR_UNCACHED | MPU_RASR_XN},
    {0x24000000u, MPU_RASR_SIZE(17) | MPU_RASR_READ_ONLY | MPU_RASR_WRITE_THROUGH},
};

/// Regions that hold tables, by bank.
static const uint32_t table_region[] = {8, 3};

/// Invalidate every line of the data cache, by set and way. No line is newer than its memory,
/// because all cached regions are read-only or written through.
static void empty_data_cache(void)
{
    SCB_CSSELR = 0; // level 1, data
    stm_barrier();
    const uint32_t geometry = SCB_CCSIDR;
    const uint32_t last_way = geometry >> 3 & 0x3FFu;
    const uint32_t last_set = geometry >> 13 & 0x7FFFu;
    for (uint32_t set = 0; set <= last_set; set++) {
        for (uint32_t way = 0; way <= last_way; way++) {
            SCB_DCISW = way << 30 | set << 5; // four ways, lines of 32 bytes
        }
    }
    stm_barrier();
}

void stm_memory_open_tables(uint32_t bank, bool is_open)
{
    const uint32_t i = table_region[bank];
    const uint32_t open = MPU_RASR_DEVICE | MPU_RASR_READ_WRITE;
    const uint32_t shut = MPU_RASR_WRITE_THROUGH | MPU_RASR_READ_ONLY;
    const uint32_t rest = regions[i].attributes & ~shut;
    stm_barrier();
    MPU_RBAR = regions[i].base | MPU_RBAR_VALID | i;
    MPU_RASR = rest | (is_open ? open : shut) | MPU_RASR_ENABLE;
    stm_barrier();
    empty_data_cache();
}

/// The content of both caches is random after a reset, so they are invalidated before they are
/// enabled.
void stm_memory_init(void)
{
    for (size_t i = 0; i < sizeof regions / sizeof regions[0]; i++) {
        MPU_RBAR = regions[i].base | MPU_RBAR_VALID | (uint32_t)i;
        MPU_RASR = regions[i].attributes | MPU_RASR_ENABLE;
    }
    MPU_CTRL = MPU_CTRL_PRIVDEFENA | MPU_CTRL_ENABLE;
    stm_barrier();
    SCB_ICIALLU = 0;
    stm_barrier();
    SCB_CCR |= SCB_CCR_IC;
    stm_barrier();
    empty_data_cache();
    SCB_CCR |= SCB_CCR_DC;
    stm_barrier();
}
