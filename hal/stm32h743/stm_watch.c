// SPDX-License-Identifier: Apache-2.0
#include "stm_watch.h"
#include "board_config.h" // BOARD_TICK_HZ
#include "stm_clock.h"    // stm_apb_hz
#include "stm_reg.h"

/// The window watchdog counts down from `from` in steps of 4096 APB3 clocks, resets below 64, and
/// may be fed from `open` on: after at least one step.
enum {
    step_clocks = 4096,
    tick_clocks = stm_apb_hz / BOARD_TICK_HZ,
    steps = 6,
    from = 64 + steps - 1,
    open = from - 1,
};
_Static_assert(tick_clocks > step_clocks, "a tick on time finds the window open");
_Static_assert((steps - 1) * step_clocks > 3 * tick_clocks, "three ticks may be late");

static void start_window(void)
{
    RCC_GCR |= RCC_GCR_WW1RSC; // resets the whole device, not only the core
    RCC_APB3ENR |= RCC_APB3ENR_WWDG1;
    (void)RCC_APB3ENR;
    DBGMCU_APB3FZ1 |= DBGMCU_APB3FZ1_WWDG1;
    WWDG_CFR = open; // prescaler 1, no interrupt
    WWDG_CR = WWDG_CR_WDGA | from;
}

/// One second is longer than the slow side needs to check the largest table.
static void start_independent(void)
{
    DBGMCU_APB4FZ1 |= DBGMCU_APB4FZ1_WDGLSD1;
    IWDG_KR = IWDG_KR_START;
    IWDG_KR = IWDG_KR_UNLOCK;
    IWDG_PR = IWDG_PR_DIV8; // 32 kHz / 8
    IWDG_RLR = 4000;
    IWDG_KR = IWDG_KR_RELOAD;
}

void stm_watch_start(void)
{
    start_independent();
    start_window();
}

void stm_watch_feed(void)
{
    IWDG_KR = IWDG_KR_RELOAD;
}

void stm_watch_tick_isr(bool is_behind)
{
    if (!is_behind) {
        WWDG_CR = WWDG_CR_WDGA | from;
    }
}
