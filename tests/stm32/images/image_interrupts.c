// SPDX-License-Identifier: Apache-2.0
// A sum whose steps are full of conditions and floating point, torn apart by an interrupt that uses
// the same registers: answer[0] rounds done, answer[1] the sum, answer[2] interrupts, answer[3] the
// number of the exception as the interrupt sees it, answer[4] wrong sums.
#include "image.h"

static volatile float disturbance = 1.0f;

void image_nmi(void) {}

void image_tim4(void)
{
    uint32_t number = 0;
    __asm volatile("mrs %0, ipsr" : "=r"(number));
    TIM4(0x10) = 0;
    disturbance = disturbance * 1.5f - 0.25f;
    disturbance = disturbance > 100.0f ? 1.0f : disturbance;
    answer[2]++;
    answer[3] = number;
}

static uint32_t sum(uint32_t n)
{
    uint32_t crc = 0;
    float x = 1.0f;
    for (uint32_t i = 0; i < n; i++) {
        const uint32_t bits = i * 2654435761u;
        crc = (bits & 1u) != 0u ? crc + bits : crc ^ bits >> 3;
        crc = (crc & 0x80000000u) != 0u ? crc << 1 ^ 0x04C11DB7u : crc << 1;
        x = x > 50.0f ? x * 0.125f : x * 1.25f + (float)(crc & 7u);
    }
    return crc + (uint32_t)(int32_t)(x * 1000.0f);
}

void image_main(void)
{
    const uint32_t wanted = sum(300);
    RCC(0xE8) = 1u << 2;         // APB1LENR: TIM4
    TIM4(0x2C) = 97;             // ARR
    TIM4(0x0C) = 1;              // DIER: UIE
    REG(0xE000E100u) = 1u << 30; // ISER0
    TIM4(0x00) = 1;              // CR1: CEN
    for (;;) {
        answer[1] = sum(300);
        answer[4] += answer[1] != wanted ? 1u : 0u;
        answer[0]++;
    }
}
