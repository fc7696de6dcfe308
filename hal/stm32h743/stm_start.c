// SPDX-License-Identifier: Apache-2.0
/// stm_start: start-up (safe outputs, memory, vectors) and the handlers of all unexpected
/// exceptions. Source: ARMv7-M Architecture Reference Manual B1.5.3 (vector table), B3.2.
#include "hal/hal.h"
#include "stm_memory.h" // stm_ecc_isr, stm_keep_may_hold, stm_memory_init
#include "stm_port.h"

extern uint32_t stm_stack_top;
extern uint32_t stm_itcm_image, stm_itcm_start, stm_itcm_end;
extern uint32_t stm_slow_image, stm_slow_start, stm_slow_end;
extern uint32_t stm_data_image, stm_data_start, stm_data_end;
extern uint64_t stm_axi_start[], stm_itcm_base[], stm_itcm_top[], stm_kept_base[], stm_kept_top[];
int main(void);
_Noreturn void stm_reset(void);
void stm_boot_fill(void);
_Noreturn void stm_run(void);

typedef void (*vector_t)(void);

/// Start-up code that runs in flash, before code is copied to RAM.
#define STM_BOOT __attribute__((section(".boot"), used, noinline))

enum { n_system = 16, n_vectors = n_system + stm_n_irqs, n_changes = 5 };

/// The clock security system raises an NMI after it has switched from the failed HSE to the HSI.
/// RM0433 8.5, CSS.
static void on_nmi(void)
{
    stm_outputs_safe();
    if ((RCC_CIFR & RCC_CIFR_HSECSSF) != 0u) {
        RCC_CICR = RCC_CICR_HSECSSC;
        hal_halt("clock: the HSE oscillator failed");
    }
    hal_halt("exception: NMI");
}

static void on_hard_fault(void)
{
    hal_halt(stm_ecc_why("exception: hard fault"));
}

static void on_memory_fault(void)
{
    hal_halt("exception: memory protection");
}

static void on_bus_fault(void)
{
    hal_halt(stm_ecc_why("exception: bus fault"));
}

static void on_usage_fault(void)
{
    hal_halt("exception: usage fault");
}

static void on_unexpected(void)
{
    hal_halt("exception: unexpected interrupt");
}

/// Exception before memory is initialised: make the outputs safe and restart.
STM_BOOT static void on_boot_fault(void)
{
    stm_outputs_safe();
    SCB_AIRCR = SCB_AIRCR_SYSRESETREQ;
    for (;;) {
    }
}

/// Vectors in flash, used at reset. Interrupts are enabled later.
__attribute__((section(".vectors"), used)) static const struct {
    uint32_t *stack_top;
    vector_t system[n_system - 1];
} flash_vectors = {
    .stack_top = &stm_stack_top,
    .system = {stm_reset, on_boot_fault, on_boot_fault, on_boot_fault, on_boot_fault, on_boot_fault,
               on_boot_fault, on_boot_fault, on_boot_fault, on_boot_fault, on_boot_fault,
               on_boot_fault, on_boot_fault, on_boot_fault, on_boot_fault},
};

/// Vectors used while the tick runs, in memory without wait states. Their alignment is
/// their size rounded up to a power of two: B3.2.5.
__attribute__((section(".ram_vectors"), aligned(1024))) static vector_t ram_vectors[n_vectors];

/// Fill the vectors in RAM and switch the core to them; each fault gets its own exception.
static void fill_vectors(void)
{
    for (uint32_t i = 0; i < n_vectors; i++) {
        ram_vectors[i] = on_unexpected;
    }
    ram_vectors[2] = on_nmi;
    ram_vectors[3] = on_hard_fault;
    ram_vectors[4] = on_memory_fault;
    ram_vectors[5] = on_bus_fault;
    ram_vectors[6] = on_usage_fault;
    ram_vectors[n_system + stm_irq_tim4] = stm_tick_isr;
    ram_vectors[n_system + stm_irq_ecc] = stm_ecc_isr;
    SCB_VTOR = (uint32_t)ram_vectors;
    SCB_SHCSR |= SCB_SHCSR_FAULTS;
    SCB_CCR |= SCB_CCR_DIV_0_TRP;
    stm_barrier();
}

/// Switch the floating-point unit on, for the slow side alone: exceptions save no registers of it,
/// because no code of theirs uses it, as tools/elfcheck proves of every image.
static void start_fpu(void)
{
    SCB_CPACR |= SCB_CPACR_FPU;
    FPU_FPCCR &= ~FPU_FPCCR_SAVES;
    stm_barrier();
}

__attribute__((always_inline)) static inline void copy(const uint32_t *from, uint32_t *to,
                                                       const uint32_t *end)
{
    while (to < end) {
        *to++ = *from++;
    }
}

/// Clear RAM with 64-bit stores. Its error-correction code, over up to 64 bits, is random after
/// power-on; a narrower store would read the word first. RM0433 chapter 3.
__attribute__((always_inline)) static inline void clear(volatile uint64_t *to, const uint64_t *end)
{
    for (; to < end; to++) {
        *to = 0;
    }
}

/// A change of a register: bits cleared, bits set.
typedef struct {
    volatile uint32_t *reg;
    uint32_t clear, set;
} change_t;

/// Changes before RAM may be written, in this order: outputs safe, the trace's pin free, supply by
/// the LDO. Then the loop waits for bit `ready` of `*wait`: the supply's voltage is valid. Until
/// then "write accesses to the RAMs are not permitted", not even to the stack, which no compiler
/// guarantees: hence a table for a loop in assembler. RM0433 6.4.1 (system supply start-up),
/// PWR_CR3.
__attribute__((section(".boot_table"), used)) const struct {
    change_t change[n_changes];
    uint32_t end;
    volatile uint32_t *wait;
    uint32_t ready;
} stm_boot_table = {
    .change =
        {
            {&RCC_AHB4ENR, 0, RCC_AHB4ENR_GPIOE | RCC_AHB4ENR_GPIOB},
            {&GPIOE->BSRR, 0, STM_SAFE_LEVELS},
            {&GPIOE->MODER, STM_OUTPUT_MODES_MASK, STM_OUTPUT_MODES},
            {&GPIOB->MODER, STM_TRACE_MODE_MASK, 0},
            {&PWR_CR3, PWR_CR3_BYPASS | PWR_CR3_SCUEN, PWR_CR3_LDOEN},
        },
    .wait = &PWR_CSR1,
    .ready = PWR_CSR1_ACTVOSRDY,
};

/// Clear the other memories (the DTCM is already clear), except the text of a halt, and copy the
/// load images.
STM_BOOT void stm_boot_fill(void)
{
    clear(stm_itcm_base, stm_itcm_top);
    clear(stm_axi_start, stm_scope_end);
    if (!stm_keep_may_hold(RCC_RSR)) {
        clear(stm_kept_base, stm_kept_top);
    }
    copy(&stm_slow_image, &stm_slow_start, &stm_slow_end);
    copy(&stm_itcm_image, &stm_itcm_start, &stm_itcm_end);
    copy(&stm_data_image, &stm_data_start, &stm_data_end);
    stm_barrier();
}

/// Runs from ITCM after start-up. From here on, flash is accessible only for tables.
__attribute__((used, noinline)) void stm_run(void)
{
    fill_vectors();
    start_fpu();
    stm_memory_init();
    (void)main();
    hal_halt("main returned");
}

/// Applies stm_boot_table, reading back each register so that its clock runs before the next
/// change; waits; clears the DTCM, stack included, with 64-bit stores. Written in assembler so that
/// nothing uses the stack too early and link-time optimisation does not inline main() here, in
/// flash. Without a valid supply it waits with safe outputs.
__attribute__((naked, section(".boot"), used)) void stm_reset(void)
{
    __asm volatile("ldr r0, =stm_boot_table\n"
                   "1: ldm r0!, {r1, r2, r3}\n"
                   "cbz r1, 2f\n"
                   "ldr r4, [r1]\n"
                   "bic r4, r4, r2\n"
                   "orr r4, r4, r3\n"
                   "str r4, [r1]\n"
                   "ldr r4, [r1]\n"
                   "b 1b\n"
                   "2: ldr r4, [r2]\n"
                   "tst r4, r3\n"
                   "beq 2b\n"
                   "ldr r0, =stm_dtcm_base\n"
                   "ldr r1, =stm_dtcm_top\n"
                   "movs r2, #0\n"
                   "movs r3, #0\n"
                   "3: strd r2, r3, [r0], #8\n"
                   "cmp r0, r1\n"
                   "blo 3b\n"
                   "bl stm_boot_fill\n"
                   "ldr r0, =stm_run\n"
                   "bx r0\n"
                   ".ltorg\n");
}
