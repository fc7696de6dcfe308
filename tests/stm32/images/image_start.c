// SPDX-License-Identifier: Apache-2.0
#include "image.h"

extern uint32_t image_stack_top;
volatile uint32_t answer[image_n_answers];

typedef void (*vector_t)(void);

static void image_reset(void)
{
    REG(0xE000ED88u) = 0xFu << 20; // floating-point unit on
    __asm volatile("dsb\n isb");
    for (uint32_t i = 0; i < image_n_answers; i++) {
        answer[i] = 0;
    }
    image_main();
    for (;;) {
    }
}

static void image_unexpected(void)
{
    for (;;) {
    }
}

__attribute__((section(".vectors"), used)) static const struct {
    uint32_t *stack_top;
    vector_t vector[16 + 31 - 1];
} vectors = {
    .stack_top = &image_stack_top,
    .vector = {image_reset, image_nmi, [2 ... 44] = image_unexpected, [16 + 30 - 1] = image_tim4},
};
