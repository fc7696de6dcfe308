// SPDX-License-Identifier: Apache-2.0
/// mps2_timer: time of the port: TIMER0 is the tick, the dual timer the free-running clock. Source:
/// ARM "Cortex-M System Design Kit" TRM, 4.4 (APB timer) and 4.5 (dual-input timers); ARMv7-M
/// Architecture Reference Manual, B3.4 (NVIC).
#include "hal/hal.h"
#include "mps2_machine.h"

enum { board_hz = 25000000, tick_hz = 20000 };

/// Registers of an APB timer.
typedef struct {
    uint32_t control, value, reload, interrupt; ///< write 1 to interrupt to clear it
} apb_timer_t;

/// Registers of one half of the dual timer.
typedef struct {
    uint32_t load, value, control;
} dual_timer_t;

#define TIMER0 (*(volatile apb_timer_t *)0x40000000u)
#define CLOCK (*(volatile dual_timer_t *)0x40002000u)
#define NVIC_SET_ENABLE (*(volatile uint32_t *)0xE000E100u)
#define NVIC_PRIORITY ((volatile uint8_t *)0xE000E400u)

enum { timer0_irq = 8, highest_priority = 0 };
enum { timer_on = 1u << 0, timer_interrupts = 1u << 3 };
enum { dual_is_32_bit = 1u << 1, dual_on = 1u << 7 };

void mps2_timer0_isr(void);

static volatile uint32_t n_ticks;
static hal_load_t load = {.cycles_hz = board_hz};

uint32_t hal_tick_hz(void)
{
    return tick_hz;
}

uint32_t hal_clock_hz(void)
{
    return board_hz;
}

uint32_t hal_clock_isr(void)
{
    return ~CLOCK.value; // counts down
}

void hal_tick_start(void)
{
    CLOCK.load = UINT32_MAX;
    CLOCK.control = dual_on | dual_is_32_bit;
    TIMER0.reload = board_hz / tick_hz - 1;
    TIMER0.value = board_hz / tick_hz - 1;
    NVIC_PRIORITY[timer0_irq] = highest_priority;
    NVIC_SET_ENABLE = 1u << timer0_irq;
    TIMER0.control = timer_on | timer_interrupts;
}

/// Wait for the next tick by polling: wfi would make the emulation depend on the host's time, and
/// runs would not be repeatable.
void hal_idle(void)
{
    const uint32_t before = n_ticks;
    while (n_ticks == before) {
    }
}

hal_load_t hal_load(void)
{
    return load;
}

void mps2_timer0_isr(void)
{
    const uint32_t begin = hal_clock_isr();
    TIMER0.interrupt = 1;
    cam_isr();
    load.last_cycles = hal_clock_isr() - begin;
    load.max_cycles = load.last_cycles > load.max_cycles ? load.last_cycles : load.max_cycles;
    mps2_machine_step_isr();
    n_ticks++;
}
