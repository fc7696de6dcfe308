// SPDX-License-Identifier: Apache-2.0
/// stm_watch: two watchdogs, which reset the device and thereby let the outputs go.
///
/// The independent one, IWDG1, has a clock of its own and bites when nobody has fed it for a
/// second: it supervises the main loop, and the tick through it. The window watchdog, WWDG1, is fed
/// by each tick at its begin. It bites when the next one does not begin within 171 to 205 us, four
/// periods, and when two are less than a step of 34 us apart, as of a tick's timer that has become
/// too fast: a controller that moves by ticks would then move faster than its limits.
#ifndef STM_WATCH_H
#define STM_WATCH_H

#include <stdbool.h> // bool

/// Start both; nothing but a reset stops them, and a debugger that holds the core. To be called
/// when the tick starts.
/// Source: RM0433 44.3, 44.4 (WWDG), 45.3 (IWDG), 60.5 (freeze). Context: slow side, once.
void stm_watch_start(void);

/// The main loop is alive. Context: slow side.
void stm_watch_feed(void);

/// A tick begins.
/// @param is_behind  the last one ended when this one was due already: it follows sooner than the
///                   window opens, and feeds nothing. Context: ISR.
void stm_watch_tick_isr(bool is_behind);

#endif
