// SPDX-License-Identifier: Apache-2.0
#include "stm_memory.h"

enum { n_rams = 4, n_banks = 2, ram_word_bytes = 8, flash_word_bytes = 32 };

/// Start of the RAM of each monitor, from monitor 1 on: AXI SRAM, ITCM, and the two halves of the
/// DTCM, which hold its even and its odd words. FAR counts double words in each of them.
static const uint32_t ram_start[n_rams] = {0x24000000u, 0x00000000u, 0x20000000u, 0x20000004u};

static uint32_t n_corrected;

void stm_ecc_init(void)
{
    for (uint32_t monitor = 1; monitor <= n_rams; monitor++) {
        RAMECC1_SR(monitor) = 0;
        RAMECC1_CR(monitor) = RAMECC_CR_ECCELEN | RAMECC_CR_ECCDEIE | RAMECC_CR_ECCDEBWIE;
    }
    NVIC_ISER(stm_irq_ecc) = 1u << stm_irq_ecc % 32u;
}

/// @param address  result, of a double error
/// @return         whether there was one
static bool find_double(uint32_t *address)
{
    for (uint32_t i = 0; i < n_rams; i++) {
        if ((RAMECC1_SR(i + 1u) & (RAMECC_SR_DEDF | RAMECC_SR_DEBWDF)) != 0u) {
            *address = ram_start[i] + ram_word_bytes * RAMECC1_FAR(i + 1u);
            return true;
        }
    }
    for (uint32_t bank = 0; bank < n_banks; bank++) {
        if ((FLASH_SR(bank) & FLASH_SR_DBECCERR) != 0u) {
            *address = 0x08000000u + (bank << 20) + flash_word_bytes * FLASH_ECC_FA(bank);
            return true;
        }
    }
    return false;
}

const char *stm_ecc_why(const char *exception)
{
    static char text[] = "memory: uncorrectable error at 0x00000000";
    enum { at_last = sizeof text - 2 };
    uint32_t address;
    if (!find_double(&address)) {
        return exception;
    }
    for (uint32_t i = 0; i < 8u; i++) {
        text[at_last - i] = "0123456789ABCDEF"[address >> 4u * i & 15u];
    }
    return text;
}

/// An interrupt without a flag was pending before stm_ecc_init().
void stm_ecc_isr(void)
{
    const char *why = stm_ecc_why("");
    if (why[0] != '\0') {
        hal_halt(why);
    }
}

/// @param i   memory: RAMs, then banks of flash
/// @param at  word in it that was corrected
static void count(uint32_t i, uint32_t at)
{
    static uint32_t last[n_rams + n_banks]; // 1 + word; 0: none yet
    n_corrected += last[i] != at + 1u ? 1u : 0u;
    last[i] = at + 1u;
}

void stm_ecc_poll(void)
{
    for (uint32_t i = 0; i < n_rams; i++) {
        if ((RAMECC1_SR(i + 1u) & RAMECC_SR_SEDCF) != 0u) {
            count(i, RAMECC1_FAR(i + 1u));
            RAMECC1_SR(i + 1u) = ~RAMECC_SR_SEDCF & RAMECC_SR_FLAGS;
        }
    }
    for (uint32_t bank = 0; bank < n_banks; bank++) {
        if ((FLASH_SR(bank) & FLASH_SR_SNECCERR) != 0u) {
            count(n_rams + bank, FLASH_ECC_FA(bank));
            FLASH_CCR(bank) = FLASH_SR_SNECCERR;
        }
    }
}

uint32_t stm_ecc_corrected(void)
{
    return n_corrected;
}
