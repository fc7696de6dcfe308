// SPDX-License-Identifier: Apache-2.0
#include "stm_port.h"

/// The window watchdog counts down from `from` in steps of 4096 APB3 clocks, resets below 64, and
/// may be fed from `open` on: after the closed steps, which end an eighth before the feed is due.
/// Fast ticks feed it only every few ticks, because the window needs a closed step.
enum {
    step_clocks = 4096,
    tick_clocks = stm_apb_hz / BOARD_TICK_HZ,
    feed_ticks = step_clocks * 8 / 7 / tick_clocks + 1,
    closed_steps = feed_ticks * tick_clocks * 7 / 8 / step_clocks,
    steps = (feed_ticks + 2) * tick_clocks / step_clocks + 2,
    from = 64 + steps - 1,
    open = from - closed_steps,
};
_Static_assert(BOARD_TICK_HZ >= 5000u && BOARD_TICK_HZ <= 50000u,
               "BOARD_TICK_HZ: give 5000 to 50000");
_Static_assert(closed_steps >= 1 && feed_ticks * tick_clocks > closed_steps * step_clocks,
               "a tick on time finds the window open, a fast one does not");
_Static_assert((steps - 1) * step_clocks > (feed_ticks + 2) * tick_clocks,
               "two ticks may be missing");
_Static_assert(from <= 127, "the counter has 7 bits");

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
    static uint32_t n_ticks; // since the last feed
    n_ticks++;
    if (n_ticks >= feed_ticks && !is_behind) {
        n_ticks = 0;
        WWDG_CR = WWDG_CR_WDGA | from;
    }
}
