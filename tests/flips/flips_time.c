// SPDX-License-Identifier: Apache-2.0
/// The time part of the port, `flips_scale` times slower than the board's so that the striker's
/// timer tells every instruction from its neighbour. The rig is called around cam_isr().
#include "flips_inner.h"
#include "hal/hal.h"

enum { board_hz = 25000000, tick_hz = 20000 };

/// Registers of one half of the dual timer.
typedef struct {
    uint32_t load, value, control;
} dual_timer_t;

#define CLOCK (*(volatile dual_timer_t *)0x40002000u)
#define NVIC_SET_ENABLE (*(volatile uint32_t *)0xE000E100u)
#define NVIC_CLEAR_PENDING (*(volatile uint32_t *)0xE000E280u)
#define NVIC_PRIORITY ((volatile uint8_t *)0xE000E400u)

enum { ticker_irq = 8, striker_irq = 9, tick_priority = 0x40, strike_priority = 0 };
enum { dual_is_32_bit = 1u << 1, dual_by_16 = 1u << 2, dual_on = 1u << 7 };

void flips_tick_isr(void);

volatile struct flips_idle flips_idle;
static volatile uint32_t n_ticks;

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

uint32_t flips_time_clock(void)
{
    return CLOCK.value;
}

void flips_time_restore(uint32_t clock, uint32_t timer)
{
    CLOCK.load = clock;
    CLOCK.control = dual_on | dual_is_32_bit | dual_by_16;
    TICKER.reload = flips_period - 1;
    TICKER.value = timer;
    NVIC_PRIORITY[ticker_irq] = tick_priority;
    NVIC_PRIORITY[striker_irq] = strike_priority;
    NVIC_SET_ENABLE = 1u << ticker_irq | 1u << striker_irq;
    TICKER.interrupt = 1;
    NVIC_CLEAR_PENDING = 1u << ticker_irq;
    TICKER.control = timer_on | timer_interrupts;
}

void hal_tick_start(void)
{
    flips_set_vectors();
    flips_time_restore(UINT32_MAX, flips_period - 1);
}

/// Wait for the next tick by polling, as hal/mps2 does.
void hal_idle(void)
{
    const uint32_t before = n_ticks;
    flips_idle.at = flips_period - TICKER.value;
    flips_idle.count++;
    while (n_ticks == before) {
    }
}

hal_load_t hal_load(void)
{
    return (hal_load_t){0};
}

void flips_tick_isr(void)
{
    TICKER.interrupt = 1;
    flips_before_isr();
    cam_isr();
    n_ticks++;
    flips_after_isr();
}
