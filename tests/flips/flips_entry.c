// SPDX-License-Identifier: Apache-2.0
/// Entries of the rig: vectors, protection unit, registers of a checkpoint.
/// Source: ARMv7-M Architecture Reference Manual, B1.5 (exceptions), B3.5 (protection unit).
#include "flips_inner.h"

#define VTOR (*(volatile uint32_t *)0xE000ED08u)
#define FPCCR (*(volatile uint32_t *)0xE000EF34u)
#define MPU_CTRL (*(volatile uint32_t *)0xE000ED94u)
#define MPU_RBAR (*(volatile uint32_t *)0xE000ED9Cu)
#define MPU_RASR (*(volatile uint32_t *)0xE000EDA0u)

extern uint32_t mps2_stack_top;
void mps2_reset(void);
void flips_tick_isr(void);
void flips_striker_isr(void);
void flips_exception_isr(void);

enum { n_vectors = 48, reset_vector = 1, ticker_vector = 24, striker_vector = 25 };

static void fill_vectors(void)
{
    for (uint32_t i = 0; i < n_vectors; i++) {
        RIG_VECTORS[i] = (uint32_t)flips_exception_isr;
    }
    RIG_VECTORS[reset_vector] = (uint32_t)mps2_reset;
    RIG_VECTORS[ticker_vector] = (uint32_t)flips_tick_isr;
    RIG_VECTORS[striker_vector] = (uint32_t)flips_striker_isr;
}

/// Later regions are in force over earlier ones. Code may not be written, data not be executed, as
/// in hal/stm32h743.
static void set_regions(void)
{
    enum { xn = 1u << 28, none = 0u << 24, full = 3u << 24, read = 6u << 24, normal = 1u << 19 };
    static const struct {
        uint32_t base, attributes;
    } regions[] = {
        {0x00000000u, read | normal | (22u - 1u) << 1},
        {0x20000000u, xn | none | normal | (22u - 1u) << 1},
        {0x20000000u, xn | full | normal | 0x7Cu << 8 | (22u - 1u) << 1}, // 1 MiB and the stack
        // the rig's own, but where a pointer into the RAM or to the stack with bit 30 flipped leads
        {0x60000000u, xn | full | normal | (24u - 1u) << 1},
        {0x60000000u, xn | none | normal | (20u - 1u) << 1},
        {0x60300000u, xn | none | normal | (20u - 1u) << 1},
        {(uint32_t)RIG_TRAMPOLINE, read | normal | (12u - 1u) << 1},
    };
    for (uint32_t i = 0; i < sizeof regions / sizeof regions[0]; i++) {
        MPU_RBAR = regions[i].base | 1u << 4 | i;
        MPU_RASR = regions[i].attributes | 1u;
    }
}

/// For a write into the code.
void flips_protect(bool is_on)
{
    MPU_CTRL = is_on ? 1u | 1u << 2 : 0u;
    __asm volatile("dsb\n isb" ::: "memory");
}

void flips_set_vectors(void)
{
    set_regions();
    flips_protect(true);
    FPCCR = (FPCCR & ~(1u << 30)) | 1u << 31; // a checkpoint finds all registers on the stack
    fill_vectors();
    VTOR = (uint32_t)RIG_VECTORS;
}

__attribute__((naked)) uint32_t flips_keep_registers(flips_context_t *context
                                                     __attribute__((unused)))
{
    __asm volatile("mov r1, sp\n"
                   "stmia r0!, {r4-r11}\n"
                   "str r1, [r0], #4\n"
                   "str lr, [r0], #4\n"
                   "vstmia r0, {s16-s31}\n"
                   "movs r0, #0\n"
                   "bx lr\n");
}

__attribute__((naked)) void flips_take_registers(const flips_context_t *context
                                                 __attribute__((unused)))
{
    __asm volatile("ldmia r0!, {r4-r11}\n"
                   "ldr r1, [r0], #4\n"
                   "ldr lr, [r0], #4\n"
                   "vldmia r0, {s16-s31}\n"
                   "mov sp, r1\n"
                   "movs r0, #1\n"
                   "bx lr\n");
}

__attribute__((naked)) void flips_striker_isr(void)
{
    __asm volatile("mrs r0, msp\n"
                   "push {r4-r11}\n"
                   "mov r1, sp\n"
                   "push {r0, lr}\n"
                   "mov r2, lr\n"
                   "bl flips_strike_isr\n"
                   "pop {r0, lr}\n"
                   "pop {r4-r11}\n"
                   "bx lr\n");
}

/// The stack may be what is broken.
__attribute__((naked)) void flips_exception_isr(void)
{
    __asm volatile("mrs r0, ipsr\n"
                   "ldr sp, =0x60FF0000\n"
                   "b flips_caught\n"
                   ".ltorg\n");
}
