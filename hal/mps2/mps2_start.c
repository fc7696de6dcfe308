// SPDX-License-Identifier: Apache-2.0
/// mps2_start: start-up: vectors, memory, floating-point unit, main(), exit status.
/// Source: ARMv7-M Architecture Reference Manual, B1.5.3 (vector table), B3.2.20 (CPACR), B3.2.21
/// (FPCCR).
#include "mps2_semihost.h"
#include <stdint.h> // uint32_t

extern uint32_t mps2_stack_top, mps2_data_image, mps2_data_start, mps2_data_end;
extern uint32_t mps2_bss_start, mps2_bss_end;
int main(void);
void mps2_reset(void);

/// Exit status after an exception.
enum { status_exception = 99 };

enum { n_core_vectors = 16, n_board_vectors = 32, timer0_vector = n_core_vectors + 8 };

#define CPACR (*(volatile uint32_t *)0xE000ED88u)
#define CPACR_FPU (0xFu << 20)
#define FPCCR (*(volatile uint32_t *)0xE000EF34u)
#define FPCCR_SAVES (3u << 30) // ASPEN, LSPEN: exceptions save its registers

/// Handler of all exceptions except the timer interrupt: end the image.
static void on_exception(void)
{
    static const char text[] = "exception\n";
    mps2_write(text, sizeof text - 1u);
    mps2_exit(status_exception);
}

/// Overridden by mps2_timer.c if linked.
__attribute__((weak, alias("on_exception"))) void mps2_timer0_isr(void);

typedef void (*vector_t)(void);

__attribute__((section(".vectors"), used)) static const struct {
    uint32_t *stack_top;
    vector_t reset;
    vector_t other[n_core_vectors - 2 + n_board_vectors];
} vectors = {
    .stack_top = &mps2_stack_top,
    .reset = mps2_reset,
    .other = {[0 ... timer0_vector - 3] = on_exception,
              [timer0_vector - 2] = mps2_timer0_isr,
              [timer0_vector - 1 ... n_core_vectors - 3 + n_board_vectors] = on_exception},
};

void mps2_reset(void)
{
    CPACR |= CPACR_FPU;
    FPCCR &= ~FPCCR_SAVES; // no interrupt uses them
    __asm volatile("dsb\n isb");
    const uint32_t *from = &mps2_data_image;
    for (uint32_t *to = &mps2_data_start; to < &mps2_data_end; to++) {
        *to = *from++;
    }
    for (uint32_t *to = &mps2_bss_start; to < &mps2_bss_end; to++) {
        *to = 0;
    }
    mps2_exit(main());
}
