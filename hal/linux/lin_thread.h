// SPDX-License-Identifier: Apache-2.0
/// lin_thread: calls the tick at a constant rate from a thread of real-time priority.
///
/// Ticks fall on the multiples of the period within each second of CLOCK_MONOTONIC. When a tick
/// ends behind the time of the next one, that is an overrun: the missed ticks are left out and
/// never made up. Both threads run on one CPU, the tick with the higher priority, so for the
/// hand-over of the firmware the tick is an interrupt. Without the right to that priority the port
/// still runs, and reports what is lost.
#ifndef LIN_THREAD_H
#define LIN_THREAD_H

#include "hal/hal.h"      // hal_load_t
#include "lin_config.h"   // lin_thread_config_t
#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool
#include <stdint.h>       // int64_t, uint32_t

/// Runs one tick. @param now_ns  CLOCK_MONOTONIC when it woke up. @return false: it was the last
/// one
typedef bool lin_thread_tick_t(int64_t now_ns);

/// Lock memory, go to the CPU; what is not permitted is reported by hal_text(), with the remedy.
/// @return false and *e when the CPU does not exist. Context: main(), before the tick.
bool lin_thread_prepare(const lin_thread_config_t *config, common_error_t *e);

/// Start the thread, with SCHED_FIFO if that is permitted. @return false and *e. Context: main().
bool lin_thread_start(const lin_thread_config_t *config, lin_thread_tick_t *tick,
                      common_error_t *e);

/// Sleep until a tick has ended that the last call did not see. @return false when it was the last
/// one. Context: main().
bool lin_thread_wait(void);

/// @return how long ticks took, in ns. Context: main().
hal_load_t lin_thread_load(void);

/// @return ticks left out since start, wraps. Context: main().
uint32_t lin_thread_overruns(void);

#endif
