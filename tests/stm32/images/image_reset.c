// SPDX-License-Identifier: Apache-2.0
// Reset by software, flags and memory behind it, the NMI, sleep, masked interrupts: answer[0] flags
// of RCC_RSR, answer[1] the word kept in memory, answer[2] NMIs, answer[3] ticks, answer[4] ticks
// that came while masked, answer[5] times that sleep ended.
#include "image.h"

static volatile uint32_t *const kept = (volatile uint32_t *)0x2001FF00u;

void image_nmi(void)
{
    RCC(0x68) = 1u << 10; // CICR: HSECSSC
    answer[2]++;
}

void image_tim4(void)
{
    TIM4(0x10) = 0;
    answer[3]++;
}

static void start_hse_with_security_system(void)
{
    RCC(0x00) |= 1u << 18;
    RCC(0x00) |= 1u << 16;
    while ((RCC(0x00) & 1u << 17) == 0u) {
    }
    RCC(0x00) |= 1u << 19;
}

void image_main(void)
{
    answer[0] = RCC(0xD0);
    answer[1] = *kept;
    if (*kept != 0x600DC0DEu) {
        *kept = 0x600DC0DEu;
        REG(0xE000ED0Cu) = 0x05FA0004u; // AIRCR: SYSRESETREQ
    }
    RCC(0xD0) = 1u << 16; // RMVF
    start_hse_with_security_system();
    RCC(0xE8) = 1u << 2;
    TIM4(0x2C) = 999;
    TIM4(0x0C) = 1;
    REG(0xE000E100u) = 1u << 30;
    __asm volatile("cpsid i");
    TIM4(0x00) = 1;
    for (volatile uint32_t i = 0; i < 2000u; i++) {
    }
    answer[4] = answer[3];
    __asm volatile("cpsie i");
    for (;;) {
        __asm volatile("wfi");
        answer[5]++;
    }
}
