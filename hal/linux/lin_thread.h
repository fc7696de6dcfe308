// SPDX-License-Identifier: Apache-2.0
/// lin_thread: calls the tick at a constant rate from a real-time thread.
///
/// Ticks are at multiples of the period within each second of CLOCK_MONOTONIC. If a tick ends after
/// the next one is due (overrun), the missed ticks are skipped and not made up. Tick and main() run
/// on one CPU and the tick has the higher priority, so it preempts main() like an interrupt.
/// Without permission for real-time priority the port still runs, with a warning.
#ifndef LIN_THREAD_H
#define LIN_THREAD_H

#include "hal/hal.h"      // hal_load_t
#include "lin_config.h"   // lin_thread_config_t
#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool
#include <stdint.h>       // int64_t, uint32_t

/// Runs one tick. @param now_ns  CLOCK_MONOTONIC at wake-up. @return false after the last tick
typedef bool lin_thread_tick_t(int64_t now_ns);

/// Lock memory and move to the CPU. Missing permissions are reported by hal_text(), with a remedy.
/// @return false and *e if the CPU does not exist. Context: main(), before the tick.
bool lin_thread_prepare(const lin_thread_config_t *config, common_error_t *e);

/// Start the thread, with SCHED_FIFO if permitted. @return false and *e on error. Context: main().
bool lin_thread_start(const lin_thread_config_t *config, lin_thread_tick_t *tick,
                      common_error_t *e);

/// Wait for the end of a tick since the last call. @return false after the last tick. Context:
/// main().
bool lin_thread_wait(void);

/// @return duration of ticks in ns. Context: main().
hal_load_t lin_thread_load(void);

/// @return missed ticks since the start, wraps. Context: main().
uint32_t lin_thread_overruns(void);

#endif
