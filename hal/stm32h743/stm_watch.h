// SPDX-License-Identifier: Apache-2.0
/// stm_watch: two watchdogs, which reset the device and so release the outputs.
///
/// The independent watchdog, IWDG1, has its own clock and resets after a second without a feed. It
/// supervises the main loop, and through it the tick. The window watchdog, WWDG1, is fed at the
/// start of each tick, above 25 kHz of every second. It resets if ticks stop, at 20 kHz after 171
/// to 205 us, or if they come so fast that a feed falls into the closed steps of 34 us: motion is
/// computed per tick, so a tick timer that runs fast would move the axes beyond their speed limits.
#ifndef STM_WATCH_H
#define STM_WATCH_H

#include <stdbool.h> // bool

/// Start both when the tick starts. Only a reset, or a debugger that halts the core, stops them.
/// Source: RM0433 44.3, 44.4 (WWDG), 45.3 (IWDG), 60.5 (freeze). Context: slow side, once.
void stm_watch_start(void);

/// Report that the main loop is running. Context: slow side.
void stm_watch_feed(void);

/// Feed the window watchdog at the start of a tick. Context: ISR.
/// @param is_behind  the last tick overran: this one may start before the window opens and does
///                   not feed the watchdog
void stm_watch_tick_isr(bool is_behind);

#endif
